#pragma once
/// Test data in ../shared, beside the checkout: scenes and references of others, too large for the
/// repository.

#include "paths.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace metrolux::core::test {

/// The file or folder `name` of ../shared, whether or not it exists.
inline std::filesystem::path sharedPath(const std::filesystem::path& name) {
    return std::filesystem::path(METROLUX_SHARED_DIR) / name;
}

enum class SharedData {
    Present,  ///< the file exists
    Absent,   ///< there is no shared folder, and nobody asked for one: tests that need it are skipped
    Broken    ///< the file is missing from a folder that exists, or that must exist: tests that need it fail
};

/// What a test makes of a `file` in the folder `root`. `required`: the folder must exist.
inline SharedData sharedState(const std::filesystem::path& file, const std::filesystem::path& root,
                              bool required) {
    if (std::filesystem::exists(file)) return SharedData::Present;
    return std::filesystem::exists(root) || required ? SharedData::Broken : SharedData::Absent;
}

/// The same for ../shared; METROLUX_REQUIRE_SHARED in the environment requires it.
inline SharedData sharedState(const std::filesystem::path& file) {
    return sharedState(file, METROLUX_SHARED_DIR, std::getenv("METROLUX_REQUIRE_SHARED") != nullptr);
}

}  // namespace metrolux::core::test

/// Stands at the beginning of a test that reads the file or folder `file` (of sharedPath()). Returns from the
/// test unless it exists. tools/test_summary.sh counts skipped tests by the text.
#define METROLUX_NEEDS_SHARED(file)                                                       \
    do {                                                                                  \
        const std::filesystem::path needed = (file);                                      \
        const auto state = metrolux::core::test::sharedState(needed);                     \
        if (state == metrolux::core::test::SharedData::Absent)                            \
            GTEST_SKIP() << "for want of ../shared: " << needed.string() << " is absent"; \
        if (state == metrolux::core::test::SharedData::Broken)                            \
            FAIL() << needed.string() << " is absent, although " << METROLUX_SHARED_DIR   \
                   << " exists or METROLUX_REQUIRE_SHARED asks for it";                   \
    } while (false)
