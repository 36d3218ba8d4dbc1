#pragma once
#include "base/transform.h"

#include <Imath/ImathBox.h>

#include <memory>
#include <optional>

namespace metrolux::core {

/// A quantity in space, one number or three a point, which can be integrated along rays. In world space.
class Volume {
  public:
    virtual ~Volume() = default;
    virtual Rgb value(const Vec3f& p) const = 0;
    /// Integral over the points of the ray at distances from `begin` to `end`, which may be infinite where
    /// nothing bounds the volume.
    virtual Rgb integral(const Vec3f& origin, const Vec3f& direction, double begin, double end) const = 0;

    struct Crossing {
        double distance = 0;
        Rgb integral{0.0f};  ///< from `begin` up to there
    };
    /// Where the integral of a channel from `begin` on exceeds `target`; nothing if it does not up to `end`.
    virtual std::optional<Crossing> cross(const Vec3f& origin, const Vec3f& direction, double begin,
                                          double end, int channel, double target) const = 0;

    /// What no value exceeds, per channel.
    virtual Rgb maximum() const = 0;
    /// A medium whose extinction this is ends there, as in Mitsuba 3: it is the bounding box, along the axes
    /// of the world, of the unit cube of the volume's own space. Imath's infinite box where nothing bounds
    /// it.
    virtual Imath::Box3d bounds() const = 0;
    /// The same everywhere.
    virtual bool isConstant() const { return false; }
};
using VolumePtr = std::shared_ptr<const Volume>;

/// `value`: finite, not negative; throws Error. Unbounded.
VolumePtr makeConstantVolume(const Rgb& value);
/// The same within bounds(), which is what Mitsuba 3 makes of a `constvolume` and of a constant where a
/// volume is expected (with the identity for toWorld). value() is the same outside of them, too.
VolumePtr makeConstantVolume(const Rgb& value, const Transform& toWorld);

/// Bounding box of the image of the unit cube. Throws Error unless the map is affine and can be inverted;
/// `what` is for the message.
Imath::Box3d boundsOfUnitCube(const Transform& toWorld, const char* what);

}  // namespace metrolux::core
