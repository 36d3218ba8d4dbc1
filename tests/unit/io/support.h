#pragma once
/// What the parser says about a text.

#include "io/mitsuba/parser.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <string>

namespace metrolux::core::test {

inline std::string scene(const std::string& body, const std::string& version = "3.0.0") {
    return "<scene version=\"" + version + "\">\n" + body + "\n</scene>\n";
}

inline mitsuba::ParsedScene parseText(const std::string& text,
                                      const std::map<std::string, std::string>& defines = {}) {
    const TemporaryFolder folder;
    return mitsuba::parseScene(folder.write("scene.xml", text), defines);
}

/// The message of the Error that `action` throws; fails the test if it throws none.
template <class Action>
std::string errorOf(const Action& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    } catch (const std::exception& error) {
        ADD_FAILURE() << "threw another exception: " << error.what();
        return "";
    }
    ADD_FAILURE() << "threw nothing";
    return "";
}

}  // namespace metrolux::core::test
