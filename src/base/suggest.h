#pragma once
#include <string>
#include <vector>

namespace metrolux::core {

/// The candidate nearest to `name` in edit distance, or "" if nothing is near: for "did you mean ...?".
std::string nearestName(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace metrolux::core
