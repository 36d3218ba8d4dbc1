#include "scattering/texture.h"

namespace metrolux::core {

Vec2f Texture::gradient(const SurfaceInteraction& si) const {
    // Central differences over a step that is small against any texel yet large against float noise.
    constexpr float kStep = 1e-4f;
    SurfaceInteraction moved = si;
    const auto at = [&](float du, float dv) {
        moved.uv = si.uv + Vec2f(du, dv);
        return scalar(moved);
    };
    return {(at(kStep, 0) - at(-kStep, 0)) / (2 * kStep), (at(0, kStep) - at(0, -kStep)) / (2 * kStep)};
}

}  // namespace metrolux::core
