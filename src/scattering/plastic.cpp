#include "scattering/plastic.h"

#include "base/error.h"
#include "base/warp.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class Plastic final : public Bsdf {
  public:
    explicit Plastic(const PlasticParameters& p)
        : eta_(p.eta),
          diffuse_(p.diffuseReflectance, 0.5f),
          specular_(p.specularReflectance, 1),
          nonlinear_(p.nonlinear),
          internal_(fresnelDiffuseReflectance(1.0f / p.eta)),
          external_(fresnelDiffuseReflectance(p.eta)) {
        specularWeight_ = specularShare(diffuse_, specular_);
    }

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        const float fresnel = fresnelDielectric(known.z, eta_);
        const float specularProbability = probabilityOfSpecular(fresnel);
        if (uLobe >= specularProbability)
            return finishSmooth(si, known, warp::squareToCosineHemisphere(u), mode);
        BsdfSample result;
        result.direction = reflectLocal(known);
        result.weight =
            deltaWeight(mode, specular_(si) * fresnel, specularProbability, known, result.direction, 1);
        if (isBlack(result.weight)) return std::nullopt;
        result.pdfForward = result.pdfReverse = specularProbability;
        result.delta = true;
        return result;
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        const float eye = fresnelDielectric(wEye.z, eta_), light = fresnelDielectric(wLight.z, eta_);
        const float scale = kInvPi * wLight.z * (1.0f - eye) * (1.0f - light) / (eta_ * eta_);
        return {base(si) * scale, (1.0f - probabilityOfSpecular(eye)) * warp::cosineHemispherePdf(wLight),
                (1.0f - probabilityOfSpecular(light)) * warp::cosineHemispherePdf(wEye)};
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        // What enters is scattered by the base; 1 - internal_ of it leaves at each try.
        return clampUnit(specular_(si) * external_ + base(si) * ((1.0f - external_) * (1.0f - internal_)));
    }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return true; }

  private:
    /// Reflectance of the base with all internal reflections, a geometric series.
    Rgb base(const SurfaceInteraction& si) const {
        const Rgb d = diffuse_(si);
        if (!nonlinear_) return d * (1.0f / (1.0f - internal_));
        return {d.x / (1.0f - d.x * internal_), d.y / (1.0f - d.y * internal_),
                d.z / (1.0f - d.z * internal_)};
    }

    float probabilityOfSpecular(float fresnel) const {
        const float specular = fresnel * specularWeight_,
                    diffuse = (1.0f - fresnel) * (1.0f - specularWeight_);
        return specular > 0 ? specular / (specular + diffuse) : 0.0f;
    }

    float eta_;
    ColorParameter diffuse_, specular_;
    bool nonlinear_;
    float internal_, external_;  ///< diffuse Fresnel reflectance of the coat from below and from above
    float specularWeight_;
};

}  // namespace

BsdfPtr makePlastic(const PlasticParameters& parameters) {
    if (!(parameters.eta > 0) || !std::isfinite(parameters.eta))
        throw Error("plastic: the ratio of the indices of refraction is {}, expected a positive number",
                    parameters.eta);
    return std::make_shared<Plastic>(parameters);
}

}  // namespace metrolux::core
