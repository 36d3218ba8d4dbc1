#pragma once
#include <string>
#include <vector>

namespace metrolux::core::mitsuba {

/// Of messages that differ only in where they are about ("scene.xml:12: ", an id) the first one, with the
/// number of the others.
std::vector<std::string> withRepetitionsCounted(const std::vector<std::string>& messages);

}  // namespace metrolux::core::mitsuba
