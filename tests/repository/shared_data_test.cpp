/// What tests make of ../shared, and the closing line of `make test`, which says how many were skipped for
/// want of it.

#include "support/shared_data.h"

#include "paths.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>
#include <sys/wait.h>

namespace metrolux::core {
namespace {

using namespace test;
using testing::HasSubstr;

TEST(SharedData, IsMissedOnlyWhereThereIsNone) {
    const TemporaryFolder folder;
    const std::filesystem::path root = folder.path() / "shared", file = root / "a.xml";
    EXPECT_EQ(sharedState(file, root, false), SharedData::Absent);
    EXPECT_EQ(sharedState(file, root, true), SharedData::Broken);
    folder.write("shared/b.xml", "");
    EXPECT_EQ(sharedState(file, root, false), SharedData::Broken);
    folder.write("shared/a.xml", "");
    EXPECT_EQ(sharedState(file, root, false), SharedData::Present);
}

std::string testCase(const std::string& name, const std::string& status, const std::string& output) {
    return "<testcase name=\"" + name + "\" classname=\"" + name + "\" time=\"1\" status=\"" + status +
           "\">\n<system-out>" + output + "\n</system-out>\n</testcase>\n";
}
const std::string kPassed = testCase("A.Passed", "run", "fine");
const std::string kFailed = testCase("A.Failed", "fail", "no");
const std::string kWanting =
    testCase("A.Wanting", "notrun", "a_test.cpp:3: Skipped\nfor want of ../shared: /x is absent");
const std::string kSkipped =
    testCase("A.Skipped", "notrun", "a_test.cpp:3: Skipped\nno &quot;chromium&quot;");

struct Summary {
    std::string text;
    int status;
};
Summary summaryOf(const std::string& testCases, const std::filesystem::path& shared) {
    const TemporaryFolder folder;
    const auto report = folder.write("report.xml", "<testsuite>\n" + testCases + "</testsuite>\n");
    const std::string command = std::string(METROLUX_SOURCE_DIR) + "/tools/test_summary.sh " +
                                report.string() + " " + shared.string();
    std::FILE* pipe = ::popen(command.c_str(), "r");
    if (!pipe) return {"", -1};
    std::string text;
    std::array<char, 256> buffer{};
    while (std::fgets(buffer.data(), int(buffer.size()), pipe)) text += buffer.data();
    const int status = ::pclose(pipe);
    return {text, WIFEXITED(status) ? WEXITSTATUS(status) : -1};
}

TEST(TestSummary, CountsAndGivesReasons) {
    const Summary s = summaryOf(kPassed + kPassed + kWanting + kWanting + kSkipped, "/nowhere");
    EXPECT_EQ(s.status, 0);
    EXPECT_EQ(s.text, "2 tests passed, 3 skipped: 2 for want of ../shared, 1 no \"chromium\"\n");
}

TEST(TestSummary, SkippingForWantOfAFolderThatIsThereIsAFailure) {
    const TemporaryFolder shared;
    EXPECT_EQ(summaryOf(kPassed + kSkipped, shared.path()).status, 0);
    const Summary s = summaryOf(kPassed + kWanting, shared.path());
    EXPECT_EQ(s.status, 1);
    EXPECT_THAT(s.text, HasSubstr("../shared is there"));
}

TEST(TestSummary, FailuresAreNamed) {
    const std::string notBuilt =
        "<testcase name=\"B\" status=\"notrun\">\n<skipped message=\"Unable to find "
        "executable\"/>\n</testcase>\n";
    const Summary s = summaryOf(kPassed + kFailed + notBuilt, "/nowhere");
    EXPECT_EQ(s.status, 1);
    EXPECT_EQ(s.text, "1 tests passed, 2 FAILED (A.Failed, B), 0 skipped\n");
    EXPECT_EQ(summaryOf("", "/nowhere").status, 1) << "nothing was run";
}

}  // namespace
}  // namespace metrolux::core
