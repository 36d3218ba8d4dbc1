#include "scattering/diffuse_specular.h"

namespace metrolux::core {
namespace {

Rgb maximum(const ColorParameter& color) {
    const Texture* texture = color.texture();
    if (!texture || texture->resolution() == Vec2i(1, 1)) return color.mean();
    const Vec2i size = texture->resolution();
    Rgb result(0.0f);
    SurfaceInteraction si{};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            si.uv = {(static_cast<float>(x) + 0.5f) / static_cast<float>(size.x),
                     (static_cast<float>(y) + 0.5f) / static_cast<float>(size.y)};
            const Rgb c = texture->rgb(si);
            for (int k = 0; k < 3; ++k) result[k] = std::max(result[k], c[k]);
        }
    return result;
}

}  // namespace

DiffuseSpecular::DiffuseSpecular(TexturePtr diffuse, float defaultDiffuse, TexturePtr specular,
                                 float defaultSpecular)
    : diffuse_(std::move(diffuse), defaultDiffuse), specular_(std::move(specular), defaultSpecular) {
    const float largest = maxComponent(maximum(diffuse_) + maximum(specular_));
    if (largest > 1) scale_ = 0.99f / largest;
    const float d = luminance(diffuse_.mean()), s = luminance(specular_.mean());
    specularProbability_ = s > 0 ? s / (d + s) : 0.0f;
}

}  // namespace metrolux::core
