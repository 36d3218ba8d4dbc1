#pragma once
/// Runs the metrolux program as a user does.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace metrolux::cli {

struct Outcome {
    int status = -1;  ///< exit status; 128 + signal if a signal ended it
    std::string out, err;
};

/// A running program. Its working directory is `folder`; output goes to files there.
class Command {
  public:
    /// `launcher`: words before those of metrolux, the first is found in PATH.
    Command(const std::filesystem::path& folder, const std::vector<std::string>& arguments,
            const std::vector<std::string>& launcher = {});
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
    ~CliTest() override;

    Outcome run(const std::vector<std::string>& arguments) const { return Command(folder, arguments).wait(); }
    void write(const std::string& name, const std::string& text) const;
    /// Waits until the file exists; false after 60 s.
    bool waitFor(const std::string& name) const;

    std::filesystem::path folder;
};

/// 24x16 pixels: a box with a rough floor, a glass sphere and an area light; $samples and $width may be
/// defined.
extern const char* const kTinyScene;

}  // namespace metrolux::cli
