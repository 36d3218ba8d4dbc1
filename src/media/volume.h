#pragma once
#include "base/math.h"

#include <memory>

namespace metrolux::core {

/// A quantity in space, one number or three a point.
class Volume {
  public:
    virtual ~Volume() = default;
    /// In world space.
    virtual Rgb value(const Vec3f& p) const = 0;
    /// The same everywhere.
    virtual bool isConstant() const { return false; }
};
using VolumePtr = std::shared_ptr<const Volume>;

VolumePtr makeConstantVolume(const Rgb& value);

}  // namespace metrolux::core
