#include "scattering/textures/checkerboard.h"

namespace metrolux::core {
namespace {

class Checkerboard final : public Texture {
  public:
    explicit Checkerboard(const CheckerboardParameters& parameters) : p_(parameters) {}

    Rgb rgb(const SurfaceInteraction& si) const override {
        return (onDiagonal(si) ? *p_.color0 : *p_.color1).rgb(si);
    }
    float scalar(const SurfaceInteraction& si) const override { return scalarAt(si).scalar(si); }
    Vec2f gradient(const SurfaceInteraction& si) const override { return scalarAt(si).gradient(si); }
    Rgb mean() const override { return (p_.color0->mean() + p_.color1->mean()) * 0.5f; }
    Vec2i resolution() const override {
        // The map may repeat the pattern: four texels for each square that the unit square sees.
        const auto texels = [](float a, float b) {
            return std::clamp(8 * static_cast<int>(std::ceil(std::abs(a) + std::abs(b))), 8, 1024);
        };
        const Vec2i a = p_.color0->resolution(), b = p_.color1->resolution();
        return {std::max({texels(p_.toUv.m[0][0], p_.toUv.m[1][0]), a.x, b.x}),
                std::max({texels(p_.toUv.m[0][1], p_.toUv.m[1][1]), a.y, b.y})};
    }

  private:
    bool onDiagonal(const SurfaceInteraction& si) const {
        const Vec2f uv = p_.toUv(si.uv);
        const bool right = uv.x - std::floor(uv.x) > 0.5f, upper = uv.y - std::floor(uv.y) > 0.5f;
        return right == upper;
    }
    /// Mitsuba 3 exchanges the two when it looks up a scalar, and scenes are made to look right there.
    const Texture& scalarAt(const SurfaceInteraction& si) const {
        return onDiagonal(si) ? *p_.color1 : *p_.color0;
    }
    CheckerboardParameters p_;
};

}  // namespace

TexturePtr makeCheckerboard(const CheckerboardParameters& parameters) {
    return std::make_shared<Checkerboard>(parameters);
}

}  // namespace metrolux::core
