#include "render/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

namespace metrolux::core {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Progress, Durations) {
    EXPECT_EQ(durationText(0.84), "0.8 s");
    EXPECT_EQ(durationText(59.97), "1 min 00 s");
    EXPECT_EQ(durationText(125), "2 min 05 s");
    EXPECT_EQ(durationText(3 * 3600 + 20 * 60 + 7), "3 h 20 min");
}

TEST(Progress, LineSaysWhatIsKnown) {
    PassReport report{7, 12, std::numeric_limits<double>::infinity(), -1};
    const std::string early = progressText(report, 2.5e6, "");
    EXPECT_THAT(early, HasSubstr("pass 7"));
    EXPECT_THAT(early, HasSubstr("2.50 Mrays/s"));
    EXPECT_THAT(early, Not(HasSubstr("error")));
    EXPECT_THAT(early, Not(HasSubstr("to go")));
    report.relativeError = 0.0312;
    report.secondsRemaining = 61;
    const std::string late = progressText(report, 2.5e6, "acceptance 0.23");
    EXPECT_THAT(late, HasSubstr("error 3.12 %"));
    EXPECT_THAT(late, HasSubstr("1 min 01 s to go"));
    EXPECT_THAT(late, HasSubstr("acceptance 0.23"));
}

TEST(Progress, TerminalLineIsOverwrittenAndNotTooFrequent) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), &std::fclose);
    {
        ProgressReporter reporter(ProgressReporter::Mode::Terminal, file.get());
        for (int pass = 1; pass <= 100; ++pass)
            reporter.update({static_cast<uint32_t>(pass), 0.01 * pass, 1, 1}, 1e6, "");
    }
    std::rewind(file.get());
    std::string text(100000, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), file.get()));
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
    EXPECT_NEAR(static_cast<double>(std::count(text.begin(), text.end(), '\r')), 10, 1);
}

TEST(Progress, AFileIsNotATerminal) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), &std::fclose);
    EXPECT_EQ(ProgressReporter::modeFor(file.get(), false), ProgressReporter::Mode::Log);
    EXPECT_EQ(ProgressReporter::modeFor(file.get(), true), ProgressReporter::Mode::Silent);
}

}  // namespace
}  // namespace metrolux::core
