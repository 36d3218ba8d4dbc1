#include "render/progress.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <sys/ioctl.h>
#include <unistd.h>

namespace metrolux::core {
namespace {

constexpr double kTerminalInterval = 0.1;
constexpr double kFirstLogInterval = 1, kLogGrowth = 1.5, kLongestLogInterval = 300;

size_t terminalWidth(std::FILE* stream) {
    winsize size{};
    if (::ioctl(::fileno(stream), TIOCGWINSZ, &size) != 0 || size.ws_col < 20) return 80;
    return size.ws_col;
}

}  // namespace

std::string durationText(double seconds) {
    if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
    const auto whole = std::lround(seconds);
    if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
    return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string progressText(const PassReport& report, double raysPerSecond, const std::string& note) {
    std::string text = fmt::format("pass {}, {}", report.passes, durationText(report.seconds));
    if (report.secondsRemaining >= 0)
        text += fmt::format(", {} to go", durationText(report.secondsRemaining));
    if (std::isfinite(report.relativeError))
        text += fmt::format(", error {:.2f} %", 100 * report.relativeError);
    text += fmt::format(", {:.2f} Mrays/s", raysPerSecond * 1e-6);
    if (!note.empty()) text += ", " + note;
    return text;
}

ProgressReporter::Mode ProgressReporter::modeFor(std::FILE* stream, bool quiet) {
    if (quiet) return Mode::Silent;
    return ::isatty(::fileno(stream)) ? Mode::Terminal : Mode::Log;
}

void ProgressReporter::update(const PassReport& report, double raysPerSecond, const std::string& note) {
    if (mode_ == Mode::Silent || report.seconds < nextUpdate_) return;
    std::string text = progressText(report, raysPerSecond, note);
    if (mode_ == Mode::Log) {
        spdlog::info("{}", text);
        nextUpdate_ = std::clamp(kLogGrowth * report.seconds, report.seconds + kFirstLogInterval,
                                 report.seconds + kLongestLogInterval);
        return;
    }
    text.resize(std::min(text.size(), terminalWidth(stream_) - 1));
    put(fmt::format("\r{}\x1b[K", text));
    lineOpen_ = true;
    nextUpdate_ = report.seconds + kTerminalInterval;
}

void ProgressReporter::finish() {
    if (lineOpen_) put("\n");
    lineOpen_ = false;
}

/// A terminal that has gone away (SIGHUP, a closed pipe) is no reason to end a rendering.
void ProgressReporter::put(const std::string& text) const {
    std::fputs(text.c_str(), stream_);
    std::fflush(stream_);
}

}  // namespace metrolux::core
