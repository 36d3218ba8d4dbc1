#pragma once
/// Named materials, with the names that Mitsuba's scenes use.

#include "base/math.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace metrolux::core {

/// Index of refraction at 589 nm (mostly Hecht, Optics, 4th edition), or nothing for an unknown name. Case
/// does not matter.
std::optional<float> namedIor(std::string_view name);
std::vector<std::string> iorNames();

struct ConductorIor {
    Rgb eta, k;
};
/// Complex index of a conductor in linear Rec.709: the measured spectra (collected by the Luxpop and SOPRA
/// databases, Palik where so named) projected on the sensitivities of RGB rendering as in Mitsuba, which is
/// why a flat spectrum is not gray. "none" is a perfect mirror. A "_palik" suffix may be left out or added
/// where there is only one set.
std::optional<ConductorIor> namedConductor(std::string_view name);
std::vector<std::string> conductorNames();

}  // namespace metrolux::core
