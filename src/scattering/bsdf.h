#pragma once
/// The BSDF interface.
///
/// Directions are unit vectors in the local shading frame of the interaction (SurfaceInteraction::toLocal),
/// both point away from the surface.
///
/// One convention makes every model usable from both ends of a path: the *scattering value*
///
///     S(wEye, wLight) = f(wLight -> wEye) * |cos(wLight)|
///
/// where f is the radiance BSDF (at a refraction it includes the factor by which radiance changes when it
/// crosses the interface: (eta_eye_side / eta_light_side)^2) and the cosine is that of the shading frame
/// which the model really uses (a normal map's nested model uses the perturbed frame). S is what the
/// rendering equation multiplies incident radiance with. A model never needs to know the adjoint: light
/// subpaths evaluate the same S with the roles of the directions exchanged, and transport/ applies the ratio
/// of *geometric* cosines at one seam. That is the adjoint of [Veach 1997, 5.3.4] exactly: S |wEye.Ng| /
/// |wLight.Ng|.

#include "base/frame.h"
#include "base/math.h"
#include "geometry/interaction.h"

#include <memory>
#include <optional>

namespace metrolux::core {

/// What the subpath that samples transports.
enum class TransportMode : uint8_t {
    Radiance,   ///< an eye subpath: the known direction points toward the eye, the light's is sampled
    Importance  ///< a light subpath: the known direction points toward the light, the eye's is sampled
};

struct BsdfEvaluation {
    Rgb value{0.0f};     ///< S(wEye, wLight), smooth (non-delta) lobes only
    float pdfLight = 0;  ///< solid-angle density with which sample() picks wLight when wEye is known
    float pdfEye = 0;    ///< solid-angle density with which sample() picks wEye when wLight is known
};

struct BsdfSample {
    Vec3f direction{0.0f};  ///< sampled direction, local
    /// S / pdf for the two directions in their roles under the mode. For a delta lobe the delta functions
    /// cancel: Radiance: F * (radiance scaling) / p;  Importance: F / p * |cos(known)| / |cos(sampled)|, with
    /// p the probability of the lobe. (The geometric-cosine ratio that transport/ applies then cancels the
    /// cosine ratio.)
    Rgb weight{0.0f};
    /// Smooth lobes: solid-angle density of `direction` given the known direction, over all smooth lobes.
    /// Delta lobes: the probability of having chosen this lobe.
    float pdfForward = 0;
    /// The same with the two directions exchanged (known <-> sampled).
    float pdfReverse = 0;
    bool delta = false;        ///< a delta lobe was sampled
    bool transmitted = false;  ///< the path crossed the surface
    /// Relative index of refraction across the event: eta on the side of `direction` / eta on the known side;
    /// 1 for reflections and index-matched transmission.
    float eta = 1;
};

/// A lobe that lets light straight on, as if there were no surface. sample() picks it for the uppermost
/// values of uLobe, with a probability that is the same for both directions along a line.
struct NullLobe {
    Rgb transmittance{0.0f};
    float probability = 0;
};

class Bsdf {
  public:
    virtual ~Bsdf() = default;

    /// Samples the other direction. `uLobe` picks the lobe, `u` the direction. Nothing is returned when the
    /// sample cannot carry light (absorbed, below the surface); that is a sample of value zero, not an error.
    virtual std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known,
                                             TransportMode mode, float uLobe, const Vec2f& u) const = 0;

    /// Value and densities of the smooth lobes for a pair of directions; zero for delta lobes.
    virtual BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                                    const Vec3f& wLight) const = 0;

    /// Fraction of the energy that the surface scatters, in [0, 1] per channel, independent of direction:
    /// survival probability of roulette and the albedo AOV. An estimate is fine; zero only where the surface
    /// is black.
    virtual Rgb albedo(const SurfaceInteraction& si) const = 0;

    virtual bool hasSmoothLobe() const = 0;  ///< can be connected and merged
    virtual bool hasDeltaLobe() const = 0;
    /// All smooth lobes have a roughness below kNarrow: of the photons that arrive from everywhere next to
    /// none are scattered in a given direction, and photon mapping had better follow the lobe.
    virtual bool isNarrow(const SurfaceInteraction&) const { return false; }
    static constexpr float kNarrow = 0.1f;
    /// Light can pass through the surface (so that both sides of it scatter into each other).
    virtual bool isTransmissive() const { return false; }
    /// Scatters light of different wavelengths (SurfaceInteraction::wavelength) differently.
    virtual bool isDispersive() const { return false; }

    // In scenes with media what goes straight on is no event of a path (transport/passage.h).

    virtual bool hasNullLobe() const { return false; }
    /// For the local direction w to either side.
    virtual NullLobe nullLobe(const SurfaceInteraction& si, const Vec3f& w) const {
        (void)si, (void)w;
        return {};
    }
    /// What the density of a vertex here has as a factor from its being chosen as the end of an edge along w
    /// (local): in a medium its extinction; where a null lobe could have been taken, the probability that it
    /// was not.
    virtual Rgb stopDensity(const SurfaceInteraction& si, const Vec3f& w) const {
        (void)si, (void)w;
        return Rgb(1.0f);
    }

  protected:
    /// Makes the sample of a smooth lobe from evaluate(): value and both densities for (known, direction).
    std::optional<BsdfSample> finishSmooth(const SurfaceInteraction& si, const Vec3f& known,
                                           const Vec3f& direction, TransportMode mode, float eta = 1) const {
        const bool radiance = mode == TransportMode::Radiance;
        const BsdfEvaluation e = radiance ? evaluate(si, known, direction) : evaluate(si, direction, known);
        BsdfSample result;
        result.direction = direction;
        result.pdfForward = radiance ? e.pdfLight : e.pdfEye;
        result.pdfReverse = radiance ? e.pdfEye : e.pdfLight;
        if (!(result.pdfForward > 0) || isBlack(e.value)) return std::nullopt;
        result.weight = e.value * (1.0f / result.pdfForward);
        result.transmitted = known.z * direction.z < 0;
        result.eta = eta;
        return result;
    }

    /// Weight of a delta lobe with energy fraction `energy` chosen with probability `probability`.
    /// `eta` as in BsdfSample. Radiance is scaled by 1/eta^2 (eye side over light side squared), importance
    /// is not.
    static Rgb deltaWeight(TransportMode mode, const Rgb& energy, float probability, const Vec3f& known,
                           const Vec3f& direction, float eta) {
        if (mode == TransportMode::Radiance) return energy * (1.0f / (probability * eta * eta));
        return energy * (absCosTheta(known) / (absCosTheta(direction) * probability));
    }
};
using BsdfPtr = std::shared_ptr<const Bsdf>;

}  // namespace metrolux::core
