#include "base/error.h"
#include "media/volume.h"

namespace metrolux::core {
namespace {

class ConstantVolume final : public Volume {
  public:
    ConstantVolume(const Rgb& value, const Imath::Box3d& bounds) : value_(value), bounds_(bounds) {
        for (int channel = 0; channel < 3; ++channel)
            if (!(value[channel] >= 0) || !std::isfinite(value[channel]))
                throw Error(
                    "constant volume: found {} in channel {}, expected a finite number that is not negative",
                    value[channel], channel);
    }
    Rgb value(const Vec3f&) const override { return value_; }
    Rgb integral(const Vec3f&, const Vec3f&, double begin, double end) const override {
        const auto length = static_cast<float>(end - begin);
        const auto of = [&](float value) { return value > 0 ? value * length : 0.0f; };  // not 0 * infinity
        return {of(value_.x), of(value_.y), of(value_.z)};
    }
    std::optional<Crossing> cross(const Vec3f&, const Vec3f&, double begin, double end, int channel,
                                  double target) const override {
        const double rate = value_[channel];
        if (!(target < rate * (end - begin))) return std::nullopt;  // as for a rate of 0
        const double distance = begin + target / rate;
        return Crossing{distance, value_ * static_cast<float>(target / rate)};
    }
    Rgb maximum() const override { return value_; }
    Imath::Box3d bounds() const override { return bounds_; }
    bool isConstant() const override { return true; }

  private:
    Rgb value_;
    Imath::Box3d bounds_;
};

}  // namespace

VolumePtr makeConstantVolume(const Rgb& value) {
    Imath::Box3d everywhere;
    everywhere.makeInfinite();
    return std::make_shared<ConstantVolume>(value, everywhere);
}

VolumePtr makeConstantVolume(const Rgb& value, const Transform& toWorld) {
    return std::make_shared<ConstantVolume>(value, boundsOfUnitCube(toWorld, "constant volume"));
}

Imath::Box3d boundsOfUnitCube(const Transform& toWorld, const char* what) {
    for (int column = 0; column < 4; ++column)
        if (toWorld.at(3, column) != (column == 3 ? 1.0 : 0.0))
            throw Error("{}: found {} in the last row of its transform, expected an affine one", what,
                        toWorld.at(3, column));
    if (toWorld.isSingular())
        throw Error("{}: its transform flattens space, expected one with an inverse", what);
    Imath::Box3d box;
    for (int corner = 0; corner < 8; ++corner)
        box.extendBy(toWorld.exactPoint(Vec3d(corner & 1, corner >> 1 & 1, corner >> 2 & 1)));
    return box;
}

}  // namespace metrolux::core
