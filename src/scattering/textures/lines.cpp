#include "scattering/textures/lines.h"

namespace metrolux::core {
namespace {

class Lines final : public Texture {
  public:
    explicit Lines(const LinesParameters& parameters) : p_(parameters) {}

    Rgb rgb(const SurfaceInteraction& si) const override { return at(si).rgb(si); }
    float scalar(const SurfaceInteraction& si) const override { return at(si).scalar(si); }
    Vec2f gradient(const SurfaceInteraction& si) const override { return at(si).gradient(si); }
    Rgb mean() const override {
        const float between = sqr(std::max(0.0f, 1 - 2 * p_.lineWidth));
        return p_.color0->mean() * between + p_.color1->mean() * (1 - between);
    }
    Vec2i resolution() const override {
        // The map may repeat the pattern.
        const auto texels = [](float a, float b) {
            return std::clamp(64 * static_cast<int>(std::ceil(std::abs(a) + std::abs(b))), 64, 2048);
        };
        return {texels(p_.toUv.m[0][0], p_.toUv.m[1][0]), texels(p_.toUv.m[0][1], p_.toUv.m[1][1])};
    }

  private:
    const Texture& at(const SurfaceInteraction& si) const {
        const Vec2f uv = p_.toUv(si.uv);
        const auto isNear = [&](float x) { return std::abs(x - std::round(x)) < p_.lineWidth; };
        return isNear(uv.x) || isNear(uv.y) ? *p_.color1 : *p_.color0;
    }
    LinesParameters p_;
};

}  // namespace

TexturePtr makeLines(const LinesParameters& parameters) { return std::make_shared<Lines>(parameters); }

}  // namespace metrolux::core
