#pragma once
/// Media of a scene file, with their phase functions and volumes.

#include "io/mitsuba/context.h"
#include "media/medium.h"

#include <optional>

namespace metrolux::core::mitsuba {

/// Null when it is left out. Throws Error.
MediumPtr makeMedium(const Element& element, LoadContext& context);  // plugins_medium.cpp
/// Adds it to the media of the scene: its place among them, 0 when it is left out. Throws Error.
MediumIndex addMedium(const Element& element, LoadContext& context);
/// The same, once for each element.
MediumIndex mediumIndex(const Element& element, LoadContext& context);
/// The medium in a sensor or an emitter, under any name. Throws Error for several.
std::optional<MediumIndex> mediumOf(const Element& element, LoadContext& context);
/// "interior" and "exterior" of a shape. Throws Error for other names.
std::optional<MediumSides> mediumSidesOf(const Element& element, LoadContext& context);

struct Scatterer {
    PhaseFunctionPtr phase;
    float albedo = 1;  ///< what a mixture whose weights sum to less than one leaves of the medium's
};
Scatterer makePhase(const Element& element, LoadContext& context);  // plugins_phase.cpp

VolumePtr makeVolume(const Element& element, LoadContext& context);  // plugins_volume.cpp

/// What a property may hold that says how much: converts spectra, names the quantity, tells the largest
/// value.
struct Quantity {
    const char* name;
    Rgb (*convert)(const SpectrumValue&);
    float largest;
};
extern const Quantity kCoefficient, kAlbedo;
/// A color, each channel from zero to the quantity's largest. Throws Error.
Rgb quantity(const Element& element, const char* name, const Quantity& kind, float fallback);
/// The same, or a volume. `bounded`: a color is that of the unit cube, as extinctions are in Mitsuba 3.
VolumePtr volumeProperty(const Element& element, const char* name, LoadContext& context, const Quantity& kind,
                         float fallback, bool bounded);

std::vector<std::string> mediumTypes();
std::vector<std::string> phaseTypes();
std::vector<std::string> volumeTypes();

}  // namespace metrolux::core::mitsuba
