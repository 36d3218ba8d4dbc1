#include "scattering/textures/scaled.h"

namespace metrolux::core {
namespace {

class ScaledTexture final : public Texture {
  public:
    explicit ScaledTexture(const ScaledTextureParameters& parameters) : p_(parameters) {}

    Rgb rgb(const SurfaceInteraction& si) const override { return p_.texture->rgb(si) * p_.scale; }
    float scalar(const SurfaceInteraction& si) const override {
        return isGray() ? p_.texture->scalar(si) * p_.scale.x : luminance(rgb(si));
    }
    Vec2f gradient(const SurfaceInteraction& si) const override {
        return p_.texture->gradient(si) * (isGray() ? p_.scale.x : luminance(p_.scale));
    }
    Rgb mean() const override { return p_.texture->mean() * p_.scale; }
    bool isConstant() const override { return p_.texture->isConstant(); }
    Vec2i resolution() const override { return p_.texture->resolution(); }

  private:
    bool isGray() const { return p_.scale.x == p_.scale.y && p_.scale.y == p_.scale.z; }

    ScaledTextureParameters p_;
};

}  // namespace

TexturePtr makeScaledTexture(const ScaledTextureParameters& parameters) {
    return std::make_shared<ScaledTexture>(parameters);
}

}  // namespace metrolux::core
