#pragma once
/// Scenes of Mitsuba before 0.4: to what 0.4 to 0.6 read, as the style sheets of 0.6 rewrite them
/// (data/schema/upgrade_0.3.0.xsl, upgrade_0.4.0.xsl and upgrade_0.5.0.xsl in its source).

#include "io/mitsuba/properties.h"

#include <string>

namespace metrolux::core::mitsuba {

/// The tag of 0.4 for one of before: camera is sensor, luminaire is emitter.
std::string tagOf04(const std::string& tag);
/// Rewrites an element of a scene of version 0.`minor`, minor < 5.
void upgradeOldest(Element& element, int minor);

}  // namespace metrolux::core::mitsuba
