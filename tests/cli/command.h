#pragma once
/// Runs the metrolux program as a user does.

#include "integrators/registry.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace metrolux::core::cli {

using Words = std::vector<std::string>;

inline Words operator+(Words a, const Words& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

struct Outcome {
    int status = -1;  ///< exit status; 128 + signal if a signal ended it
    std::string out, err;
};

/// Names of all integrators.
inline Words integratorNames() {
    Words names;
    for (const IntegratorDescription& integrator : integratorList()) names.push_back(integrator.name);
    return names;
}

/// A running program. Its working directory is `folder`; output goes to files there.
class Command {
  public:
    /// `launcher`: words before those of metrolux, the first is found in PATH.
    Command(const std::filesystem::path& folder, const Words& arguments, const Words& launcher = {});
    ~Command();
    Command(const Command&) = delete;
    Command& operator=(const Command&) = delete;
    void signal(int number) const;
    int pid() const { return pid_; }
    Outcome wait();

  private:
    int pid_ = -1;
    std::filesystem::path out_, err_;
};

/// A fresh folder for each test, and a tiny scene in it.
class CliTest : public testing::Test {
  protected:
    CliTest();

    Outcome run(const Words& arguments) const { return Command(folder, arguments).wait(); }
    void write(const std::string& name, const std::string& text) const { temporary_.write(name, text); }
    /// Waits until the file exists; false after 60 s.
    bool waitFor(const std::string& name) const;
    /// Of an image in the folder.
    std::vector<float> pixels(const std::string& image) const;

  private:
    test::TemporaryFolder temporary_;

  protected:
    const std::filesystem::path folder = temporary_.path();
};

/// 24x16 pixels: a box with a rough floor, a glass sphere and an area light; $samples and $width may be
/// defined.
extern const char* const kTinyScene;

}  // namespace metrolux::core::cli
