#pragma once
/// Values of parameters for tests that go through all of them.

#include "base/parameter.h"

#include <algorithm>

namespace metrolux::core::test {

/// Some values that the parameter takes, other than its default.
inline std::vector<ParameterValue> otherValues(const ParameterInfo& info) {
    std::vector<ParameterValue> candidates{true, false, 1, 3, 0.3, 0.7, 9.5, "u", "uv", "1/2/3", "auto"};
    candidates.insert(candidates.end(), info.choices.begin(), info.choices.end());
    std::vector<ParameterValue> result;
    for (const ParameterValue& candidate : candidates) {
        try {
            const ParameterValue value = info.checked(candidate);
            if (value != info.defaultValue && std::find(result.begin(), result.end(), value) == result.end())
                result.push_back(value);
        } catch (const Error&) {
            // not one of its values
        }
    }
    return result;
}

}  // namespace metrolux::core::test
