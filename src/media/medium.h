#pragma once
#include "media/phase_function.h"
#include "media/volume.h"

namespace metrolux::core {

/// A participating medium. All is known in closed form along a ray: an optical thickness is integrated, not
/// estimated, so that the densities of paths are numbers and a path stays a function of its primary sample.
/// Units: coefficients per unit of world length, per channel. (docs/explain/media.md)
class Medium {
  public:
    explicit Medium(PhaseFunctionPtr phase) : phase_(std::move(phase)) {}
    virtual ~Medium() = default;

    /// Integral of the extinction along the segment, `length` > 0, perhaps infinite.
    virtual Rgb thickness(const Vec3f& origin, const Vec3f& direction, float length) const = 0;

    struct Flight {
        float distance = 0;
        Rgb thickness{0.0f};  ///< up to there
    };
    /// Where the thickness of a channel reaches `target` >= 0, nothing when it does not on the segment.
    virtual std::optional<Flight> fly(const Vec3f& origin, const Vec3f& direction, float length, int channel,
                                      float target) const = 0;

    virtual Rgb extinction(const Vec3f& p) const = 0;
    virtual Rgb scattering(const Vec3f& p) const = 0;
    /// False where light is only absorbed: nothing happens on the way through it.
    virtual bool scatters() const = 0;

    const PhaseFunction& phase() const { return *phase_; }

  private:
    PhaseFunctionPtr phase_;
};
using MediumPtr = std::shared_ptr<const Medium>;

/// Finite, `extinction` >= 0, `albedo` in [0, 1]; throws Error.
MediumPtr makeHomogeneousMedium(const Rgb& extinction, const Rgb& albedo, PhaseFunctionPtr phase);
/// The extinction is `density` times `scale`, within the bounds of `density`; outside is empty space. What
/// the medium says of points is what the volumes have there: whoever asks comes from fly(), and single
/// precision may have put such a point just outside, or on the other side of a step to zero. `scale` finite
/// and not negative, albedo in [0, 1]; throws Error.
MediumPtr makeHeterogeneousMedium(VolumePtr density, float scale, VolumePtr albedo, PhaseFunctionPtr phase);

}  // namespace metrolux::core
