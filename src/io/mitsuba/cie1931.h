#pragma once
#include <array>

namespace metrolux::core::mitsuba {

/// The CIE 1931 2-degree observer: 360 to 830 nm in steps of 5 nm.
inline constexpr int kCieSamples = 95;
inline constexpr double kCieFirst = 360, kCieLast = 830;
extern const std::array<float, kCieSamples> kCieX, kCieY, kCieZ;

}  // namespace metrolux::core::mitsuba
