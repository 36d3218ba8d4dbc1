#pragma once
#include "render/pass_loop.h"

#include <cstdio>
#include <string>

namespace metrolux::core {

/// "0.8 s", "2 min 05 s", "3 h 20 min".
std::string durationText(double seconds);

/// One line after a pass: pass, time, time remaining, error, rays per second, the integrator's note.
std::string progressText(const PassReport& report, double raysPerSecond, const std::string& note);

/// Shows progress: one line that is overwritten on a terminal, else log lines at growing intervals.
class ProgressReporter {
  public:
    enum class Mode { Silent, Terminal, Log };
    /// What suits standard error.
    static Mode modeFor(std::FILE* stream, bool quiet);

    explicit ProgressReporter(Mode mode, std::FILE* stream = stderr) : mode_(mode), stream_(stream) {}
    ~ProgressReporter() { finish(); }
    ProgressReporter(const ProgressReporter&) = delete;
    ProgressReporter& operator=(const ProgressReporter&) = delete;

    void update(const PassReport& report, double raysPerSecond, const std::string& note);
    /// Ends the terminal's line, before anything else is printed.
    void finish();

  private:
    void put(const std::string& text) const;
    Mode mode_;
    std::FILE* stream_;
    double nextUpdate_ = 0;
    bool lineOpen_ = false;
};

}  // namespace metrolux::core
