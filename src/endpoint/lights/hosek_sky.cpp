#include "endpoint/lights/hosek_sky.h"

#include "base/error.h"

#include <array>

namespace metrolux::core {

namespace {

/// Mitsuba 3's MI_CIE_Y_NORMALIZATION, 1 / 106.75; Mitsuba 0.6 divides by 106.857.
constexpr double kNormalization = 1.0 / 106.7502593994140625;

using Weights = std::array<double, kHosekControls>;

/// Bernstein polynomials of degree five in the cube root of the elevation (section 5.2 of the paper).
Weights elevationWeights(double elevation) {
    const double x = std::cbrt(elevation / (std::numbers::pi / 2)), y = 1 - x;
    return {y * y * y * y * y,      5 * y * y * y * y * x, 10 * y * y * y * x * x,
            10 * y * y * x * x * x, 5 * y * x * x * x * x, x * x * x * x * x};
}

}  // namespace

HosekSky::HosekSky(float turbidity, const Rgb& albedo, float elevation) {
    if (!(turbidity >= 1 && turbidity <= 10))
        throw Error("the turbidity {} is out of range, expected 1 to 10", turbidity);
    for (int c = 0; c < 3; ++c)
        if (!(albedo[c] >= 0 && albedo[c] <= 1))
            throw Error("the albedo ({}, {}, {}) is out of range, expected 0 to 1", albedo.x, albedo.y,
                        albedo.z);
    if (!(elevation >= 0 && elevation <= 0.5001f * kPi))
        throw Error("the sun is below the horizon (elevation {:.2f} degrees)", elevation * 180 / kPi);

    const Weights weights = elevationWeights(std::min(double(elevation), std::numbers::pi / 2));
    const int low = std::min(static_cast<int>(turbidity), kHosekTurbidities - 1) - 1;
    const double t = turbidity - static_cast<float>(low + 1);
    for (int c = 0; c < kHosekChannels; ++c) {
        // Linear in turbidity and albedo.
        const auto interpolate = [&](const auto& at) {
            double sum = 0;
            for (int k = 0; k < kHosekControls; ++k)
                for (int a = 0; a < kHosekAlbedos; ++a)
                    sum += weights[static_cast<size_t>(k)] * (a == 0 ? 1 - albedo[c] : albedo[c]) *
                           ((1 - t) * at(a, low, k) + t * at(a, low + 1, k));
            return sum;
        };
        for (int i = 0; i < kHosekShapes; ++i)
            shape_[c][i] = interpolate([&](int a, int j, int k) { return kHosekSkyShape[c][a][j][k][i]; });
        scale_[c] = interpolate([&](int a, int j, int k) { return kHosekSkyRadiance[c][a][j][k]; });
    }
}

Rgb HosekSky::radiance(double cosTheta, double gamma) const {
    const double cosine = std::max(cosTheta, 0.0), cosGamma = std::cos(gamma),
                 cos2Gamma = cosGamma * cosGamma;
    Rgb result;
    for (int c = 0; c < kHosekChannels; ++c) {
        const double* s = shape_[c];
        // Equations 8 and 9: Perez' formula with an anisotropic term chi around the sun.
        const double base = 1 + s[8] * s[8] - 2 * s[8] * cosGamma;
        const double chi = (1 + cos2Gamma) / (base * std::sqrt(base));
        const double value =
            (1 + s[0] * std::exp(s[1] / (cosine + 0.01))) *
            (s[2] + s[3] * std::exp(s[4] * gamma) + s[5] * cos2Gamma + s[6] * chi + s[7] * std::sqrt(cosine));
        result[c] = static_cast<float>(std::max(value * scale_[c] * kNormalization, 0.0));
    }
    return result;
}

}  // namespace metrolux::core
