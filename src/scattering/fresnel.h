#pragma once
/// Fresnel equations at a smooth interface, unpolarized light (Born & Wolf 1999, sections 1.5 and 14.2).

#include "base/math.h"

namespace metrolux::core {

/// Reflectance of a dielectric interface. `cosThetaI` is signed: positive on the side of the normal, where
/// the index is that of the exterior; `eta` is interior over exterior. Returns the reflectance; sets the
/// signed cosine of the refracted direction (0 at total internal reflection; its sign is opposite to that of
/// cosThetaI) and the index ratios along the way of travel: etaIt = index on the far side over index on the
/// near side, etaTi = 1 / etaIt.
inline float fresnelDielectric(float cosThetaI, float eta, float& cosThetaT, float& etaIt, float& etaTi) {
    const bool outside = cosThetaI >= 0;
    const float inverse = 1.0f / eta;
    etaIt = outside ? eta : inverse;
    etaTi = outside ? inverse : eta;
    const float ci = std::abs(cosThetaI);
    const float ct = safeSqrt(1.0f - (1.0f - ci * ci) * etaTi * etaTi);  // Snell's law
    cosThetaT = outside ? -ct : ct;
    if (eta == 1.0f) return 0.0f;
    if (ci == 0) return 1.0f;
    const float s = (ci - etaIt * ct) / (ci + etaIt * ct);
    const float p = (ct - etaIt * ci) / (ct + etaIt * ci);
    return 0.5f * (s * s + p * p);
}

/// The reflectance alone.
inline float fresnelDielectric(float cosThetaI, float eta) {
    float cosThetaT, etaIt, etaTi;
    return fresnelDielectric(cosThetaI, eta, cosThetaT, etaIt, etaTi);
}

/// Reflectance of a conductor with the complex index eta + ik (relative to the exterior), per channel.
/// `cosThetaI` >= 0.
Rgb fresnelConductor(float cosThetaI, const Rgb& eta, const Rgb& k);

/// Hemispherical mean of Schlick's approximation, from the reflectance at normal incidence: F0 + (1 - F0)
/// / 21.
inline Rgb schlickMean(const Rgb& f0) { return f0 * (20.0f / 21.0f) + Rgb(1.0f / 21.0f); }

/// Mean reflectance of a dielectric interface under diffuse illumination from outside; `eta` is the index of
/// the far side over that of the near side. Polynomial fits: below 1 Egan & Hilgeman 1973, above d'Eon &
/// Irving 2011 (the constants that Mitsuba 3 uses; relative error below 1 % for indices up to 2).
float fresnelDiffuseReflectance(float eta);

}  // namespace metrolux::core
