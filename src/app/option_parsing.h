#pragma once
/// Reads the values of command-line options. All functions throw Error that says what was expected.

#include <metrolux/scene.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace metrolux::core::app {

/// "90", "60s", "5m", "1.5h", "1h30m": seconds, positive and at most a hundred years.
double parseDuration(const std::string& text);
/// The same, or "0": seconds between two events, 0 for never.
double parseInterval(const std::string& text);
/// "0.02", "2%": a relative error, positive.
double parseRelativeError(const std::string& text);
/// "4G", "512M", "1000000": bytes, powers of 1024.
size_t parseMemory(const std::string& text);

/// "1280x720".
Resolution parseResolution(const std::string& text);
/// "x,y,width,height".
Crop parseCrop(const std::string& text);

/// The words of the command that this process runs, the program's name first.
std::vector<std::string> commandWords();

struct Range {
    uint32_t first = 0, last = 0;
};
/// "3" or "0-7".
Range parseRange(const std::string& text);

/// "name=value" each.
std::map<std::string, std::string> parseDefines(const std::vector<std::string>& texts);

}  // namespace metrolux::core::app
