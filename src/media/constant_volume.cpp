#include "media/volume.h"

namespace metrolux::core {
namespace {

class ConstantVolume final : public Volume {
  public:
    explicit ConstantVolume(const Rgb& value) : value_(value) {}
    Rgb value(const Vec3f&) const override { return value_; }
    bool isConstant() const override { return true; }

  private:
    Rgb value_;
};

}  // namespace

VolumePtr makeConstantVolume(const Rgb& value) { return std::make_shared<ConstantVolume>(value); }

}  // namespace metrolux::core
