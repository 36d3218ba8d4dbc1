#pragma once
/// Microfacet theory: normal distributions, Smith shadowing and visible normals.
///
/// [Walter07] Microfacet Models for Refraction through Rough Surfaces
/// [Heitz14]  Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs
/// [Jakob14]  An Improved Visible Normal Sampling Routine for the Beckmann Distribution
/// [Dupuy23]  Sampling Visible GGX Normals with Spherical Caps
///
/// Vectors are local, microfacet normals m have m.z >= 0.

#include "base/frame.h"
#include "base/math.h"

namespace metrolux::core {

enum class MicrofacetType : uint8_t { Beckmann, Ggx };

class MicrofacetDistribution {
  public:
    static constexpr float kMinAlpha = 1e-4f;

    /// Roughness along the tangent and the bitangent, not less than kMinAlpha (as in Mitsuba 3).
    MicrofacetDistribution(MicrofacetType type, float alphaU, float alphaV)
        : type_(type), alphaU_(std::max(alphaU, kMinAlpha)), alphaV_(std::max(alphaV, kMinAlpha)) {}

    /// Density of normals, per solid angle of m and area of the macrosurface: the integral of D m.z is 1.
    float d(const Vec3f& m) const;

    /// Smith masking of one direction [Walter07, 27 and 34]; 0 when v sees the back of m. `v` may lie on
    /// either side. Beckmann's is the rational fit of [Walter07], which Mitsuba evaluates.
    float g1(const Vec3f& v, const Vec3f& m) const;

    /// A normal seen from v (v.z > 0), with density visiblePdf().
    Vec3f sampleVisible(const Vec3f& v, const Vec2f& u) const;

    /// D G1(v) / |cos v|: the density of sampleVisible() per solid angle of m, divided by |v.m|. `v` may lie
    /// on either side; `dOfM` is d(m). The masking is the exact one here: densities must be those of the
    /// sampler.
    float visiblePdfOverCosine(const Vec3f& v, const Vec3f& m, float dOfM) const;
    float visiblePdf(const Vec3f& v, const Vec3f& m) const {
        return visiblePdfOverCosine(v, m, d(m)) * absDot(v, m);
    }

  private:
    Vec2f sampleBeckmannSlope(float cosTheta, float sinTheta, const Vec2f& u) const;
    float projectedRoughness2(const Vec3f& v) const { return sqr(alphaU_ * v.x) + sqr(alphaV_ * v.y); }

    MicrofacetType type_;
    float alphaU_, alphaV_;
};

/// Mirror of v about m; the sign of m does not matter.
inline Vec3f reflectAbout(const Vec3f& v, const Vec3f& m) { return m * (2.0f * dot(v, m)) - v; }

/// Refraction of v at a facet with normal m; cosThetaT and etaTi from fresnelDielectric(dot(v, m), eta, ...).
inline Vec3f refractAbout(const Vec3f& v, const Vec3f& m, float cosThetaT, float etaTi) {
    return m * (dot(v, m) * etaTi + cosThetaT) - v * etaTi;
}

/// Light that an interface with these facets reflects, as a fraction of what arrives from `w` (w.z > 0),
/// after single scattering; `eta` is the index of the far side over that of w's side. Gauss-Legendre
/// quadrature over the primary samples, `nodes` in each dimension.
float microfacetReflectance(const MicrofacetDistribution& distribution, const Vec3f& w, float eta, int nodes);
/// The same for the light that is refracted.
float microfacetTransmittance(const MicrofacetDistribution& distribution, const Vec3f& w, float eta,
                              int nodes);

}  // namespace metrolux::core
