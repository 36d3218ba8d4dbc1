#pragma once
/// Checks of option values with messages for people.

#include "base/error.h"

#include <CLI/CLI.hpp>

#include <charconv>
#include <cmath>
#include <cstdint>

namespace metrolux::core::app {

/// A whole number from `least` to `most`.
template <class Integer>
CLI::Validator wholeNumber(Integer least, Integer most) {
    return CLI::Validator(
        [least, most](const std::string& text) -> std::string {
            Integer value = 0;
            const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
            if (code == std::errc() && end == text.data() + text.size() && value >= least && value <= most)
                return {};
            return fmt::format("'{}' is not a whole number from {} to {}", text, least, most);
        },
        "");
}

/// A finite number above zero, or not below it.
inline CLI::Validator realNumber(bool zeroAllowed) {
    return CLI::Validator(
        [zeroAllowed](const std::string& text) -> std::string {
            double value = 0;
            const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
            if (code == std::errc() && end == text.data() + text.size() && std::isfinite(value) &&
                (value > 0 || (zeroAllowed && value == 0)))
                return {};
            return fmt::format("'{}' is not a {}", text,
                               zeroAllowed ? "number of zero or more" : "number above zero");
        },
        "");
}

}  // namespace metrolux::core::app
