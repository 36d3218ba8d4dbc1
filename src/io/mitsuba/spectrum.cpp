#include "io/mitsuba/spectrum.h"

#include "scattering/cie1931.h"

namespace metrolux::core::mitsuba {

namespace {

/// Mitsuba's MI_CIE_Y_NORMALIZATION: the integral of the observer's Y against D65 (100 at 560 nm), over 100.
constexpr double kNormalization = 1.0 / 106.7502593994140625;

/// Planck's law: W per m^2 per sr per nm.
double planck(double nanometers, double kelvin) {
    constexpr double kLight = 299792458.0, kPlanck = 6.62607015e-34, kBoltzmann = 1.380649e-23;
    const double lambda = nanometers * 1e-9;
    const double exponent = kPlanck * kLight / (lambda * kBoltzmann * kelvin);
    return 1e-9 * 2 * kPlanck * kLight * kLight / (std::pow(lambda, 5) * std::expm1(exponent));
}

/// Linear between the given wavelengths, zero outside.
double interpolate(const SpectrumValue& s, double nanometers) {
    const auto above = std::upper_bound(s.wavelengths.begin(), s.wavelengths.end(), nanometers);
    if (above == s.wavelengths.begin()) return 0;
    if (above == s.wavelengths.end()) return s.wavelengths.back() == nanometers ? s.values.back() : 0;
    const size_t i = static_cast<size_t>(above - s.wavelengths.begin()) - 1;
    const double w0 = s.wavelengths[i], w1 = s.wavelengths[i + 1];
    const double t = (nanometers - w0) / (w1 - w0);
    return (1 - t) * s.values[i] + t * s.values[i + 1];
}

/// Mitsuba's rule: 1000 points from end to end, each with a thousandth of the interval.
Xyz integrate(const SpectrumValue& s) {
    constexpr int kSteps = 1000;
    Xyz sum;
    for (int i = 0; i < kSteps; ++i) {
        const double nanometers = kCieFirst + (kCieLast - kCieFirst) * i / (kSteps - 1);
        const double value = s.blackbodyKelvin > 0 ? planck(nanometers, s.blackbodyKelvin) * s.values[0]
                                                   : interpolate(s, nanometers);
        const Xyz o = cieObserver(nanometers);
        sum.x += o.x * value;
        sum.y += o.y * value;
        sum.z += o.z * value;
    }
    const double scale = (kCieLast - kCieFirst) / kSteps * kNormalization;
    return {sum.x * scale, sum.y * scale, sum.z * scale};
}

Rgb convert(const SpectrumValue& s) {
    if (s.values.empty()) return Rgb(0.0f);
    if (s.wavelengths.empty() && !(s.blackbodyKelvin > 0)) return Rgb(s.values[0]);
    return rec709Of(integrate(s));
}

Rgb clampBelow(const Rgb& c) { return {std::max(c.x, 0.0f), std::max(c.y, 0.0f), std::max(c.z, 0.0f)}; }

}  // namespace

Rgb reflectanceFromSpectrum(const SpectrumValue& spectrum) {
    Rgb c = clampBelow(convert(spectrum));
    if (spectrum.blackbodyKelvin > 0 && maxComponent(c) > 0) c *= spectrum.values[0] / maxComponent(c);
    return {std::min(c.x, 1.0f), std::min(c.y, 1.0f), std::min(c.z, 1.0f)};
}

Rgb emissionFromSpectrum(const SpectrumValue& spectrum) { return clampBelow(convert(spectrum)); }

Rgb unboundedFromSpectrum(const SpectrumValue& spectrum) { return clampBelow(convert(spectrum)); }

}  // namespace metrolux::core::mitsuba
