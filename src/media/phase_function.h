#pragma once
#include "base/math.h"
#include "media/volume.h"

#include <memory>
#include <span>

namespace metrolux::core {

/// How a medium scatters: a density over the sphere that depends on the angle between the directions of
/// travel before and after, and so is the same from both ends of a path.
class PhaseFunction {
  public:
    virtual ~PhaseFunction() = default;
    struct Sample {
        float cosine = 1;
        float density = 0;  ///< evaluate() of it
    };
    /// Per solid angle; integrates to one. `cosine` is 1 straight on and -1 straight back. `p`: in world
    /// space, for functions that differ from place to place.
    virtual float evaluate(const Vec3f& p, float cosine) const = 0;
    /// Exactly in proportion to evaluate(). `uLobe` picks a part, `u` the angle.
    virtual Sample sample(const Vec3f& p, float uLobe, float u) const = 0;
};
using PhaseFunctionPtr = std::shared_ptr<const PhaseFunction>;

PhaseFunctionPtr makeIsotropicPhase();
/// Henyey & Greenstein 1941; the mean cosine g is in (-1, 1), positive forward. Throws Error.
PhaseFunctionPtr makeHenyeyGreensteinPhase(float g);
/// 3 / (16 pi) (1 + cosine^2)
PhaseFunctionPtr makeRayleighPhase();
/// Piecewise linear in the cosine between values at equal steps from -1 (straight back) to 1 (straight on),
/// normalized here. Two values at least, finite, none negative and not all zero; throws Error.
PhaseFunctionPtr makeTabulatedPhase(std::span<const float> values);
/// (1 - weight) first + weight second. The weight is the luminance of a volume in [0, 1]; throws Error.
PhaseFunctionPtr makeBlendPhase(PhaseFunctionPtr first, PhaseFunctionPtr second, VolumePtr weight);

}  // namespace metrolux::core
