#include "scattering/fresnel.h"

namespace metrolux::core {
namespace {

float conductorReflectance(float cosine, float eta, float k) {
    // With a + ib the normal component of the refracted wave vector (Born & Wolf 14.2):
    const float cos2 = cosine * cosine, sin2 = 1.0f - cos2;
    const float real = eta * eta - k * k - sin2;
    const float modulus = safeSqrt(real * real + 4.0f * eta * eta * k * k);  // a^2 + b^2
    const float a = safeSqrt(0.5f * (modulus + real));
    const float cross = 2.0f * cosine * a;
    const float s = (modulus + cos2 - cross) / (modulus + cos2 + cross);
    const float sum = modulus * cos2 + sin2 * sin2;
    if (!(sum > 0)) return s;  // eta = k = 0 at normal incidence
    const float p = s * (sum - cross * sin2) / (sum + cross * sin2);
    return 0.5f * (s + p);
}

}  // namespace

Rgb fresnelConductor(float cosThetaI, const Rgb& eta, const Rgb& k) {
    const float cosine = std::clamp(cosThetaI, 0.0f, 1.0f);
    return {conductorReflectance(cosine, eta.x, k.x), conductorReflectance(cosine, eta.y, k.y),
            conductorReflectance(cosine, eta.z, k.z)};
}

float fresnelDiffuseReflectance(float eta) {
    const float r = 1.0f / eta;
    if (eta < 1.0f) return ((-1.4399f * eta + 0.7099f) * eta + 0.6681f) + 0.0636f * r;
    return ((((-1.36881f * r + 4.98554f) * r - 7.80989f) * r + 6.75335f) * r - 3.4793f) * r + 0.919317f;
}

}  // namespace metrolux::core
