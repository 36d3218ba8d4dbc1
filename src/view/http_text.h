#pragma once
#include <map>
#include <string>

namespace metrolux::core::view {

/// "%20" and "+" decoded; what is no such sequence stays as it is.
std::string percentDecoded(const std::string& text);
/// "/frame?side=0&layer=color" in parts.
void splitTarget(const std::string& target, std::string& path, std::map<std::string, std::string>& query);

}  // namespace metrolux::core::view
