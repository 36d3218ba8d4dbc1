#pragma once
/// A nested model in a tilted shading frame: the common part of bump and normal maps (Mitsuba 3's semantics).
///
/// - Light counts only where a direction is on the same side of the tilted and of the original frame. Mitsuba
/// asks
///   this of the light's direction; here both are asked, so that S does not depend on who samples.
/// - flipInvalidNormals: where the eye would see the back of the tilted normal, the normal is tilted to the
/// other side
///   (Schuessler et al. 2017). The frame then depends on the direction to the eye; a light subpath, which
///   does not know it yet, samples both candidates.
/// - useShadowing: the terminator is softened by the masking of a GGX distribution that has the normal as its
/// typical
///   one (Estevez et al., A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem, Ray
///   Tracing Gems, 2019), applied to the direction to the light.

#include "scattering/bsdf.h"

namespace metrolux::core {

struct PerturbationOptions {
    bool flipInvalidNormals = true;
    bool useShadowing = true;
};

class PerturbedBsdf : public Bsdf {
  public:
    PerturbedBsdf(BsdfPtr nested, const PerturbationOptions& options)
        : nested_(std::move(nested)), options_(options) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const final;
    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye, const Vec3f& wLight) const final;
    Rgb albedo(const SurfaceInteraction& si) const final { return nested_->albedo(si); }
    bool hasSmoothLobe() const final { return nested_->hasSmoothLobe(); }
    bool hasDeltaLobe() const final { return nested_->hasDeltaLobe(); }
    bool isNarrow(const SurfaceInteraction& si) const final { return nested_->isNarrow(si); }
    bool isTransmissive() const final { return nested_->isTransmissive(); }
    bool isDispersive() const final { return nested_->isDispersive(); }

  protected:
    /// The tilted normal in the local frame, of any length; where it is degenerate nothing is tilted.
    virtual Vec3f normal(const SurfaceInteraction& si) const = 0;

  private:
    Vec3f unitNormal(const SurfaceInteraction& si) const;
    bool isFlipped(const Vec3f& n, const Vec3f& wEye) const;
    float flippedProbability(const Vec3f& n, const Vec3f& wLight) const;

    BsdfPtr nested_;
    PerturbationOptions options_;
};

}  // namespace metrolux::core
