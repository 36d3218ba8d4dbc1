#pragma once
#include "io/mitsuba/properties.h"

namespace metrolux::core::mitsuba {

/// The value of a string property out of a list, whose first is the default. Throws Error.
template <class T>
T choice(const Element& element, const std::string& name,
         const std::vector<std::pair<std::string, T>>& choices) {
    const std::string found = element.string(name, choices.front().first);
    std::string known;
    for (const auto& [text, value] : choices) {
        if (found == text) return value;
        known += (known.empty() ? "" : ", ") + text;
    }
    const Property* property = element.find(name);
    throw element.error(*property, fmt::format("found \"{}\", expected one of: {}", found, known));
}

}  // namespace metrolux::core::mitsuba
