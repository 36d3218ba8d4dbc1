#pragma once
/// Parts that the two principled models share, with the constants of Mitsuba 3.
///
/// [Burley12] Physically Based Shading at Disney
/// [Burley15] Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering

#include "base/frame.h"
#include "base/math.h"
#include "scattering/microfacet.h"

namespace metrolux::core::principled {

/// (1 - cos)^5, the angular part of Schlick's approximation.
inline float schlickWeight(float cosine) {
    const float m = std::clamp(1.0f - cosine, 0.0f, 1.0f);
    return sqr(sqr(m)) * m;
}

/// Schlick's R0 of a dielectric.
inline float reflectanceAtNormal(float eta) { return sqr((eta - 1.0f) / (eta + 1.0f)); }

/// Base color divided by its luminance; white where that is zero.
inline Rgb tint(const Rgb& baseColor) {
    const float l = luminance(baseColor);
    return l > 0 ? baseColor * (1.0f / l) : Rgb(1.0f);
}

/// GGX facets for a roughness and an anisotropy [Burley12, section 5.4].
inline MicrofacetDistribution facets(float roughness, float anisotropic) {
    const float alpha = sqr(roughness), aspect = safeSqrt(1.0f - 0.9f * anisotropic);
    return {MicrofacetType::Ggx, std::max(0.001f, alpha / aspect), std::max(0.001f, alpha * aspect)};
}

/// Diffuse and retro-reflection [Burley12, section 5.3], blended by `flatness` with the fake subsurface lobe
/// [Burley15, section 4], without base color and 1/pi. Cosines are positive; `cosHalf` is that between either
/// direction and the half vector.
inline float diffuseShape(float roughness, float flatness, float cosEye, float cosLight, float cosHalf) {
    const float eye = schlickWeight(cosEye), light = schlickWeight(cosLight);
    const float retro = 2.0f * roughness * sqr(cosHalf);
    const float shape =
        (1.0f - 0.5f * eye) * (1.0f - 0.5f * light) + retro * (eye + light + eye * light * (retro - 1.0f));
    if (flatness == 0) return shape;
    const float at90 = 0.5f * retro;
    const float subsurface = lerp(light, 1.0f, at90) * lerp(eye, 1.0f, at90);
    const float flat = 1.25f * (subsurface * (1.0f / (cosLight + cosEye) - 0.5f) + 0.5f);
    return lerp(flatness, shape, flat);
}

/// The clear coat: isotropic GTR with exponent 1 [Burley12, appendix B.2].
class Clearcoat {
  public:
    explicit Clearcoat(float gloss) : alpha2_(sqr(lerp(gloss, 0.1f, 0.001f))) {}

    /// Distribution of normals; written with the sine, which keeps its precision at the peak.
    float d(const Vec3f& m) const {
        if (!(m.z > 0)) return 0;
        const float t = m.x * m.x + m.y * m.y + alpha2_ * m.z * m.z;
        return (alpha2_ - 1.0f) / (kPi * std::log(alpha2_) * t);
    }
    /// Density of sample() per solid angle of m.
    float pdf(const Vec3f& m) const { return d(m) * m.z; }
    Vec3f sample(const Vec2f& u) const {
        const float sin2 = std::max(0.0f, (std::pow(alpha2_, 1.0f - u.y) - alpha2_) / (1.0f - alpha2_));
        const float sine = std::sqrt(sin2), phi = 2.0f * kPi * u.x;
        return {sine * std::cos(phi), sine * std::sin(phi), safeSqrt(1.0f - sin2)};
    }
    /// Smith masking, GGX with the fixed roughness 0.25.
    static float g1(const Vec3f& v) {
        const float z = std::abs(v.z);
        return 2.0f * z / (z + std::sqrt(z * z + 0.0625f * std::max(0.0f, 1.0f - z * z)));
    }

  private:
    float alpha2_;
};

}  // namespace metrolux::core::principled
