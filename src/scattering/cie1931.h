#pragma once
#include "base/math.h"

#include <array>

namespace metrolux::core {

/// The CIE 1931 2-degree observer: 360 to 830 nm in steps of 5 nm.
inline constexpr int kCieSamples = 95;
inline constexpr double kCieFirst = 360, kCieLast = 830;
extern const std::array<float, kCieSamples> kCieX, kCieY, kCieZ;

struct Xyz {
    double x = 0, y = 0, z = 0;
};
/// What the observer sees of light of one wavelength (nanometers): linear between the samples.
Xyz cieObserver(double nanometers);
/// ITU-R BT.709 primaries, D65. Negative where the color lies outside of their triangle, as that of every
/// single wavelength does.
Rgb rec709Of(const Xyz& color);

}  // namespace metrolux::core
