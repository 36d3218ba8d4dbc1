#pragma once
#include "base/math.h"

#include <span>
#include <string>
#include <string_view>

namespace metrolux::core {

/// Coefficients of a real material, per millimeter. (Jensen, Marschner, Levoy, Hanrahan, A Practical Model
/// for Subsurface Light Transport, 2001; Narasimhan, Gupta, Donner, Ramamoorthi, Nayar, Jensen, Acquiring
/// Scattering Properties of Participating Media by Dilution, 2006)
struct MediumPreset {
    const char* name;
    Rgb scattering, absorption;
    Rgb meanCosine;  ///< zero where the scattering is the reduced one
};

/// As Mitsuba 0.6 and pbrt 4 have them: of the same measurements, with other digits and names.
extern const std::span<const MediumPreset> kMitsubaPresets, kPbrtPresets;

/// By its name in upper or lower case, or null.
const MediumPreset* findMediumPreset(std::span<const MediumPreset> presets, std::string_view name);
/// All names, with commas between.
std::string mediumPresetNames(std::span<const MediumPreset> presets);

}  // namespace metrolux::core
