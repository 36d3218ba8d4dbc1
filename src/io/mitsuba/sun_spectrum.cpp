#include "io/mitsuba/sun_spectrum.h"

#include "io/mitsuba/spectrum.h"

#include <array>
#include <numbers>
#include <span>

namespace metrolux::core::mitsuba {

namespace {

struct Sample {
    float wavelength, value;
};

// Iqbal's tables, as Preetham et al. print them; wavelengths in nm. Zero beyond their ends.
// clang-format off
/// Radiance of the sun's disc outside the atmosphere, W / (m^2 sr nm).
constexpr Sample kSun[] = {
    {380, 16559.0f}, {390, 16233.7f}, {400, 21127.5f}, {410, 25888.2f}, {420, 25829.1f}, {430, 24232.3f},
    {440, 26760.5f}, {450, 29658.3f}, {460, 30545.4f}, {470, 30057.5f}, {480, 30663.7f}, {490, 28830.4f},
    {500, 28712.1f}, {510, 27825.0f}, {520, 27100.6f}, {530, 27233.6f}, {540, 26361.3f}, {550, 25503.8f},
    {560, 25060.2f}, {570, 25311.6f}, {580, 25355.9f}, {590, 25134.2f}, {600, 24631.5f}, {610, 24173.2f},
    {620, 23685.3f}, {630, 23212.1f}, {640, 22827.7f}, {650, 22339.8f}, {660, 21970.2f}, {670, 21526.7f},
    {680, 21097.9f}, {690, 20728.3f}, {700, 20240.4f}, {710, 19870.8f}, {720, 19427.2f}, {730, 19072.4f},
    {740, 18628.9f}, {750, 18259.2f}};
/// Absorption of ozone, 1/cm.
constexpr Sample kOzone[] = {
    {355, 0}, {445, 0.003f}, {450, 0.003f}, {455, 0.004f}, {460, 0.006f}, {465, 0.008f}, {470, 0.009f},
    {475, 0.012f}, {480, 0.014f}, {485, 0.017f}, {490, 0.021f}, {495, 0.025f}, {500, 0.03f}, {505, 0.035f},
    {510, 0.04f}, {515, 0.045f}, {520, 0.048f}, {525, 0.057f}, {530, 0.063f}, {535, 0.07f}, {540, 0.075f},
    {545, 0.08f}, {550, 0.085f}, {555, 0.095f}, {560, 0.103f}, {565, 0.11f}, {570, 0.12f}, {575, 0.122f},
    {580, 0.12f}, {585, 0.118f}, {590, 0.115f}, {595, 0.12f}, {600, 0.125f}, {605, 0.13f}, {610, 0.12f},
    {620, 0.105f}, {630, 0.09f}, {640, 0.079f}, {650, 0.067f}, {660, 0.057f}, {670, 0.048f}, {680, 0.036f},
    {690, 0.028f}, {700, 0.023f}, {710, 0.018f}, {720, 0.014f}, {730, 0.011f}, {740, 0.01f}, {750, 0.009f},
    {760, 0.007f}};
/// Absorption of water vapor.
constexpr Sample kWater[] = {{689, 0}, {690, 0.016f}, {700, 0.024f}, {710, 0.0125f}, {720, 1.0f}, {730, 0.87f},
                             {740, 0.061f}, {750, 0.001f}};
// Mixed gases absorb from 759 nm on, where the table of the sun has ended.

constexpr double kFirstLimb = 320, kLimbStep = 40;
/// Limb darkening: polynomials in the cosine of the angle on the sun's surface, at 320 nm, 360 nm ... 720 nm.
constexpr std::array<double, 6> kLimb[] = {
    {0.087657, 0.767174, 0.658123, -1.02953, 0.703297, -0.186735},
    {0.122953, 1.01278, 0.238687, -1.12208, 1.17087, -0.424947},
    {0.123511, 1.08444, -0.405598, 0.370629, -0.240567, 0.0674778},
    {0.158489, 1.23346, -0.875754, 0.857812, -0.484919, 0.110895},
    {0.198587, 1.30507, -1.25998, 1.49727, -1.04047, 0.299516},
    {0.23695, 1.29927, -1.28034, 1.37760, -0.85054, 0.21706},
    {0.26892, 1.34319, -1.58427, 1.91271, -1.31350, 0.37295},
    {0.299804, 1.36718, -1.80884, 2.29294, -1.60595, 0.454874},
    {0.33551, 1.30791, -1.79382, 2.44646, -1.89082, 0.594769},
    {0.364007, 1.27316, -1.73824, 2.28535, -1.70203, 0.517758},
    {0.389704, 1.2448, -1.69708, 2.14061, -1.51803, 0.440004}};
// clang-format on

double interpolate(std::span<const Sample> table, double wavelength) {
    if (wavelength < table.front().wavelength || wavelength > table.back().wavelength) return 0;
    size_t i = 0;
    while (i + 2 < table.size() && wavelength >= table[i + 1].wavelength) ++i;
    const double t =
        (wavelength - table[i].wavelength) / (double(table[i + 1].wavelength) - table[i].wavelength);
    return (1 - t) * table[i].value + t * table[i + 1].value;
}

/// Of the disc's mean, at the cosine mu.
double limbDarkening(double wavelength, double mu) {
    const double x = std::clamp((wavelength - kFirstLimb) / kLimbStep, 0.0, double(std::size(kLimb) - 1));
    const size_t i = std::min(static_cast<size_t>(x), std::size(kLimb) - 2);
    double value = 0, mean = 0, power = 1;
    for (size_t j = 0; j < 6; ++j) {
        const double c = std::lerp(kLimb[i][j], kLimb[i + 1][j], x - double(i));
        value += c * power;
        mean += c * 2 / double(j + 2);  // the mean of mu^j over the disc's area
        power *= mu;
    }
    return value / mean;
}

}  // namespace

SpectrumValue sunSpectrum(double zenith, double turbidity) {
    constexpr double kOzoneCm = 0.35, kWaterCm = 2, kAngstromExponent = 1.3;
    const double beta = 0.04608365822050 * turbidity - 0.04586025928522;
    const double degrees = zenith * 180 / std::numbers::pi;
    const double mass = 1 / (std::cos(zenith) + 0.15 * std::pow(93.885 - degrees, -1.253));
    SpectrumValue result;
    for (int wavelength = 380; wavelength <= 750; wavelength += 5) {
        const double micrometers = wavelength / 1000.0;
        const double rayleigh = 0.008735 * std::pow(micrometers, -4.08);
        const double aerosol = beta * std::pow(micrometers, -kAngstromExponent);
        const double ozone = interpolate(kOzone, wavelength) * kOzoneCm;
        const double water = interpolate(kWater, wavelength) * kWaterCm;
        const double vapor = 0.2385 * water / std::pow(1 + 20.07 * water * mass, 0.45);
        result.wavelengths.push_back(static_cast<float>(wavelength));
        result.values.push_back(static_cast<float>(interpolate(kSun, wavelength) *
                                                   std::exp(-mass * (rayleigh + aerosol + ozone + vapor))));
    }
    return result;
}

std::vector<Rgb> sunProfile(double zenith, double turbidity, int steps) {
    const SpectrumValue spectrum = sunSpectrum(zenith, turbidity);
    const Rgb uniform = emissionFromSpectrum(spectrum);
    if (steps <= 1) return {uniform};
    std::vector<Rgb> profile;
    Rgb mean(0.0f);
    for (int i = 0; i < steps; ++i) {
        const double share = double(i) / (steps - 1), mu = std::sqrt(1 - share);
        SpectrumValue darkened = spectrum;
        for (size_t j = 0; j < darkened.values.size(); ++j)
            darkened.values[j] *= static_cast<float>(limbDarkening(darkened.wavelengths[j], mu));
        profile.push_back(emissionFromSpectrum(darkened));
        mean += profile.back() * ((i == 0 || i == steps - 1 ? 0.5f : 1.0f) / static_cast<float>(steps - 1));
    }
    for (Rgb& c : profile)  // what the steps lose of the mean
        for (int k = 0; k < 3; ++k)
            if (mean[k] > 0) c[k] *= uniform[k] / mean[k];
    return profile;
}

}  // namespace metrolux::core::mitsuba
