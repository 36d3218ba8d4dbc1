#pragma once
/// A folder that is removed after the test, and what the parser says about a text.

#include "io/mitsuba/parser.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace metrolux::test {

class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "metrolux_io_XXXXXX").string();
        if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
        path_ = pattern;
    }
    ~TemporaryFolder() {
        std::error_code code;
        std::filesystem::remove_all(path_, code);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    std::filesystem::path write(const std::string& name, const std::string& text) const {
        const std::filesystem::path file = path_ / name;
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file, std::ios::binary) << text;
        return file;
    }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

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

}  // namespace metrolux::test
