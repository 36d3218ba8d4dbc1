#include "scattering/textures/constant.h"

namespace metrolux::core {
namespace {

class ConstantTexture final : public Texture {
  public:
    explicit ConstantTexture(const Rgb& value) : value_(value) {}
    Rgb rgb(const SurfaceInteraction&) const override { return value_; }
    /// Exact for gray values, which luminance() would round.
    float scalar(const SurfaceInteraction&) const override {
        return value_.x == value_.y && value_.y == value_.z ? value_.x : luminance(value_);
    }
    Vec2f gradient(const SurfaceInteraction&) const override { return {0, 0}; }
    Rgb mean() const override { return value_; }
    bool isConstant() const override { return true; }

  private:
    Rgb value_;
};

}  // namespace

TexturePtr makeConstantTexture(const Rgb& value) { return std::make_shared<ConstantTexture>(value); }

}  // namespace metrolux::core
