#include "io/mitsuba/repetitions.h"

#include <fmt/format.h>

#include <unordered_map>

namespace metrolux::core::mitsuba {
namespace {

/// From the element on, without its id.
std::string withoutPlace(const std::string& message) {
    const size_t element = message.find(": <");
    std::string result = element == std::string::npos ? message : message.substr(element);
    const size_t id = result.find(" id=\""), end = result.find('>');
    if (id == std::string::npos || end == std::string::npos || id > end) return result;
    return result.erase(id, end - id);
}

}  // namespace

std::vector<std::string> withRepetitionsCounted(const std::vector<std::string>& messages) {
    std::vector<std::string> result;
    std::vector<size_t> repetitions;
    std::unordered_map<std::string, size_t> seen;
    for (const std::string& message : messages) {
        const auto [entry, isNew] = seen.emplace(withoutPlace(message), result.size());
        if (!isNew) {
            ++repetitions[entry->second];
            continue;
        }
        result.push_back(message);
        repetitions.push_back(0);
    }
    for (size_t i = 0; i < result.size(); ++i)
        if (repetitions[i] > 0) result[i] += fmt::format(" (and {} more like it)", repetitions[i]);
    return result;
}

}  // namespace metrolux::core::mitsuba
