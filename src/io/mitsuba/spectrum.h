#pragma once
/// Spectra as linear Rec.709 RGB, as Mitsuba 3's RGB variants convert them (the releases that made the `cbox`
/// scene's RGB fragments from its spectral ones): a wavelength list is integrated against the CIE 1931
/// observer without an illuminant, and divided by the integral of the observer's Y under Mitsuba's D65,
/// 106.75. So a flat list is the equal-energy white (1.205, 0.948, 0.909) times its value; a uniform value is
/// gray. Beyond its ends a list is zero.

#include "io/mitsuba/properties.h"

namespace metrolux::core::mitsuba {

/// Each channel clamped to [0, 1]. A blackbody is normalized so that its largest channel is values[0].
Rgb reflectanceFromSpectrum(const SpectrumValue& spectrum);
/// Not negative. A blackbody is radiance in W / (m^2 sr nm) times values[0].
Rgb emissionFromSpectrum(const SpectrumValue& spectrum);
/// For indices of refraction, absorption and the like: not negative.
Rgb unboundedFromSpectrum(const SpectrumValue& spectrum);

}  // namespace metrolux::core::mitsuba
