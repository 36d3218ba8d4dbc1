#include "scattering/microfacet.h"

#include "scattering/fresnel.h"

#include <array>
#include <vector>

namespace metrolux::core {
namespace {

constexpr float kInvSqrtPi = 0.5641895835f;

/// Inverse of erf for |x| < 1 (Giles 2010, Approximating the erfinv function, single precision).
float erfInverse(float x) {
    float w = -std::log((1.0f - x) * (1.0f + x));
    const auto horner = [&w](const std::array<float, 9>& c) {
        float p = c[0];
        for (size_t i = 1; i < c.size(); ++i) p = p * w + c[i];
        return p;
    };
    if (w < 5.0f) {
        w -= 2.5f;
        return x * horner({2.81022636e-08f, 3.43273939e-07f, -3.5233877e-06f, -4.39150654e-06f,
                           0.00021858087f, -0.00125372503f, -0.00417768164f, 0.246640727f, 1.50140941f});
    }
    w = std::sqrt(w) - 3.0f;
    return x * horner({-0.000200214257f, 0.000100950558f, 0.00134934322f, -0.00367342844f, 0.00573950773f,
                       -0.0076224613f, 0.00943887047f, 1.00167406f, 2.83297682f});
}

/// Nodes and weights of the Gauss-Legendre rule on [0, 1]; weights sum to 1. Newton iterations on the
/// Legendre polynomial from Chebyshev's points.
void gaussLegendre(int n, std::vector<float>& nodes, std::vector<float>& weights) {
    nodes.resize(static_cast<size_t>(n));
    weights.resize(static_cast<size_t>(n));
    for (int i = 0; i < n; ++i) {
        double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), derivative = 1;
        for (int iteration = 0; iteration < 30; ++iteration) {
            double p = x, previous = 1;
            for (int k = 2; k <= n; ++k) {
                const double next = ((2 * k - 1) * x * p - (k - 1) * previous) / k;
                previous = p;
                p = next;
            }
            derivative = n * (x * p - previous) / (x * x - 1);
            const double step = p / derivative;
            x -= step;
            if (std::abs(step) < 1e-15) break;
        }
        nodes[static_cast<size_t>(i)] = static_cast<float>(0.5 * (1 - x));
        weights[static_cast<size_t>(i)] = static_cast<float>(1 / ((1 - x * x) * derivative * derivative));
    }
}

/// Mean of integrand(m) over the visible normals.
template <class Integrand>
float meanOverVisibleNormals(const MicrofacetDistribution& distribution, const Vec3f& w, int count,
                             Integrand&& integrand) {
    std::vector<float> nodes, weights;
    gaussLegendre(count, nodes, weights);
    double sum = 0;
    for (size_t i = 0; i < nodes.size(); ++i)
        for (size_t j = 0; j < nodes.size(); ++j)
            sum += static_cast<double>(weights[i] * weights[j]) *
                   integrand(distribution.sampleVisible(w, Vec2f(nodes[i], nodes[j])));
    return static_cast<float>(sum);
}

}  // namespace

float MicrofacetDistribution::d(const Vec3f& m) const {
    if (!(m.z > 0)) return 0;
    const float area = kPi * alphaU_ * alphaV_;
    const float slope = sqr(m.x / alphaU_) + sqr(m.y / alphaV_), cos2 = m.z * m.z;
    const float value = type_ == MicrofacetType::Beckmann ? std::exp(-slope / cos2) / (area * cos2 * cos2)
                                                          : 1.0f / (area * sqr(slope + cos2));
    // Mitsuba's cut-off too: smaller values would leave the range of float in products with other densities.
    return value * m.z > 1e-20f && value < kInfinity ? value : 0.0f;
}

float MicrofacetDistribution::g1(const Vec3f& v, const Vec3f& m) const {
    if (!(dot(v, m) * v.z > 0)) return 0;
    const float rough2 = projectedRoughness2(v), z = std::abs(v.z);
    if (type_ == MicrofacetType::Ggx) return 2.0f * z / (z + std::sqrt(z * z + rough2));
    const float rough = std::sqrt(rough2);
    if (z >= 1.6f * rough) return 1;
    const float a = z / rough;
    return (3.535f * a + 2.181f * a * a) / (1.0f + 2.276f * a + 2.577f * a * a);
}

float MicrofacetDistribution::visiblePdfOverCosine(const Vec3f& v, const Vec3f& m, float dOfM) const {
    if (!(dot(v, m) * v.z > 0)) return 0;
    const float rough2 = projectedRoughness2(v), z = std::abs(v.z);
    if (type_ == MicrofacetType::Ggx) return 2.0f * dOfM / (z + std::sqrt(z * z + rough2));
    // G1 / |cos v| = 2 / (z (1 + erf a) + rough exp(-a^2) / sqrt(pi)), a = z / rough  [Walter07, 26 with 27]
    const float rough = std::sqrt(rough2);
    if (z > 4.0f * rough) return dOfM / z;
    const float a = z / rough;
    return 2.0f * dOfM / (z * (1.0f + std::erf(a)) + rough * kInvSqrtPi * std::exp(-a * a));
}

Vec3f MicrofacetDistribution::sampleVisible(const Vec3f& v, const Vec2f& u) const {
    const Vec3f w = normalize(Vec3f(alphaU_ * v.x, alphaV_ * v.y, v.z));  // the same seen at roughness 1
    const float phi = 2.0f * kPi * u.x;
    if (type_ == MicrofacetType::Ggx) {
        // [Dupuy23]: a mirrored ray of the unit hemisphere is uniform on the cap z > -w.z.
        const float height = (1.0f - u.y) * (1.0f + w.z), z = height - w.z;
        const float r = safeSqrt(u.y * (1.0f + w.z) * (1.0f + z));
        const Vec3f h(alphaU_ * (r * std::cos(phi) + w.x), alphaV_ * (r * std::sin(phi) + w.y), height);
        return normalize(h);
    }
    const float sinTheta = std::sqrt(w.x * w.x + w.y * w.y);
    const float cosPhi = sinTheta > 0 ? w.x / sinTheta : 1.0f, sinPhi = sinTheta > 0 ? w.y / sinTheta : 0.0f;
    const Vec2f slope = sampleBeckmannSlope(w.z, sinTheta, u);
    return normalize(Vec3f(-alphaU_ * (cosPhi * slope.x - sinPhi * slope.y),
                           -alphaV_ * (sinPhi * slope.x + cosPhi * slope.y), 1.0f));
}

Vec2f MicrofacetDistribution::sampleBeckmannSlope(float cosTheta, float sinTheta, const Vec2f& u) const {
    // Slopes seen along x have the density (cosTheta - s sinTheta) exp(-s^2), s < cot theta. Its integral is
    // inverted by Newton steps in x = erf(s), where it is nearly linear [Jakob14], inside a bracket that
    // keeps them safe.
    constexpr float kLimit = 1.0f - 0x1p-23f;
    const float cotTheta = sinTheta > 0 ? cosTheta / sinTheta : kInfinity;
    const float upper = std::min(std::erf(cotTheta), kLimit);
    const float edge = sinTheta > 0 ? sinTheta * kInvSqrtPi * std::exp(-cotTheta * cotTheta) : 0.0f;
    const float target = u.x * (cosTheta * (1.0f + std::erf(cotTheta)) + edge);
    float low = -kLimit, high = upper;
    // Exact at grazing incidence, exp(-s^2) = u, and at normal incidence, erf(s) = 2 u - 1; a blend between.
    const float grazing = std::erf(std::sqrt(-std::log(std::clamp(u.x, 1e-7f, kOneMinusEpsilon))));
    float x = upper - (upper + 1.0f) * lerp(cosTheta, grazing, 1.0f - u.x);
    for (int i = 0; i < 12; ++i) {
        if (!(x > low && x < high)) x = 0.5f * (low + high);
        const float s = erfInverse(x);
        const float error = cosTheta * (1.0f + x) + sinTheta * kInvSqrtPi * std::exp(-s * s) - target;
        if (std::abs(error) < 1e-6f * (cosTheta + sinTheta)) break;
        (error > 0 ? high : low) = x;
        x -= error / (cosTheta - s * sinTheta);
    }
    x = std::clamp(x, -kLimit, upper);
    return {erfInverse(x), erfInverse(std::clamp(2.0f * u.y - 1.0f, -kLimit, kLimit))};
}

float microfacetReflectance(const MicrofacetDistribution& distribution, const Vec3f& w, float eta,
                            int nodes) {
    return meanOverVisibleNormals(distribution, w, nodes, [&](const Vec3f& m) {
        const Vec3f reflected = reflectAbout(w, m);
        if (!(reflected.z > 0)) return 0.0f;
        return distribution.g1(reflected, m) * fresnelDielectric(dot(w, m), eta);
    });
}

float microfacetTransmittance(const MicrofacetDistribution& distribution, const Vec3f& w, float eta,
                              int nodes) {
    return meanOverVisibleNormals(distribution, w, nodes, [&](const Vec3f& m) {
        float cosThetaT, etaIt, etaTi;
        const float f = fresnelDielectric(dot(w, m), eta, cosThetaT, etaIt, etaTi);
        const Vec3f refracted = refractAbout(w, m, cosThetaT, etaTi);
        if (!(refracted.z < 0)) return 0.0f;
        return distribution.g1(refracted, m) * (1.0f - f);
    });
}

}  // namespace metrolux::core
