#pragma once
#include "io/mitsuba/properties.h"

namespace metrolux::core::mitsuba {

/// uniform, regular, irregular, blackbody, d65, srgb and srgb_d65.
const std::vector<std::string>& spectrumPluginNames();
bool isSpectrumPlugin(const std::string& type);
/// The value of an element of such a type. Throws Error for wrong parameters.
decltype(Property::value) spectrumFromPlugin(const Element& element);

}  // namespace metrolux::core::mitsuba
