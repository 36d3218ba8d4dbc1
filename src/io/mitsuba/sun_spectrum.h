#pragma once
/// Direct sunlight through a clear atmosphere, as Mitsuba 0.6 takes it from Preetham, Shirley & Smits, A
/// Practical Analytic Model for Daylight (SIGGRAPH 1999, appendix A.1), who have it from Iqbal, An
/// Introduction to Solar Radiation (1983).

#include "io/mitsuba/properties.h"

namespace metrolux::core::mitsuba {

/// Mean radiance of the sun's disc in W / (m^2 sr nm) at an angle from the zenith (radians, up to pi/2).
SpectrumValue sunSpectrum(double zenith, double turbidity);

/// The same as linear RGB, at `steps` equal steps of area from the disc's center to its limb, darkened toward
/// the limb (Neckel & Labs 1994 in the fit of Hosek & Wilkie 2013) such that the mean over the disc is that
/// of sunSpectrum. One step: the uniform disc.
std::vector<Rgb> sunProfile(double zenith, double turbidity, int steps);

}  // namespace metrolux::core::mitsuba
