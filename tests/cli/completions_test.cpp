/// Completions for shells and the manual page: each option that help shows is in all of them.

#include "command.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

namespace metrolux::core::cli {
namespace {

using testing::HasSubstr;

class CompletionsTest : public CliTest {
  protected:
    std::string completions(const std::string& kind) const {
        const Outcome outcome = run({"completions", kind});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return outcome.out;
    }
    /// Long options at the start of the lines of a command's help.
    std::set<std::string> optionsInHelp(const std::string& command) const {
        static const std::regex pattern(R"(^\s+(?:-\w,)?(--[\w-]+))");
        std::set<std::string> names;
        std::istringstream lines(run({command, "--help"}).out);
        for (std::string line; std::getline(lines, line);)
            if (std::smatch match; std::regex_search(line, match, pattern)) names.insert(match[1]);
        return names;
    }
};

TEST_F(CompletionsTest, EachOptionOfHelpIsInAllOfThem) {
    const std::string bash = completions("bash"), zsh = completions("zsh"), fish = completions("fish"),
                      man = completions("man");
    for (const char* command :
         {"render", "resume", "merge", "compare", "study", "bench", "info", "convert"}) {
        const std::set<std::string> options = optionsInHelp(command);
        EXPECT_GT(options.size(), 2u) << command;
        for (const std::string& option : options) {
            EXPECT_THAT(bash, HasSubstr(option)) << command;
            EXPECT_THAT(zsh, HasSubstr("'*" + option)) << command;
            EXPECT_THAT(fish, HasSubstr(" -l " + option.substr(2) + " ")) << command;
            EXPECT_THAT(man, HasSubstr(std::regex_replace(option, std::regex("-"), "\\-"))) << command;
        }
    }
}

TEST_F(CompletionsTest, BashTakesThem) {
    write("complete.sh",
          completions("bash") +
              "COMP_WORDS=(metrolux render --resol) COMP_CWORD=2\n_metrolux\necho \"${COMPREPLY[@]}\"\n"
              "COMP_WORDS=(metrolux conv) COMP_CWORD=1\n_metrolux\necho \"${COMPREPLY[@]}\"\n");
    ASSERT_EQ(
        std::system(("bash '" + (folder / "complete.sh").string() + "' > '" + (folder / "out").string() + "'")
                        .c_str()),
        0);
    std::ostringstream out;
    out << std::ifstream(folder / "out").rdbuf();
    EXPECT_EQ(out.str(), "--resolution\nconvert\n");
}

TEST_F(CompletionsTest, AnotherShellIsRefused) {
    const Outcome outcome = run({"completions", "csh"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr("'csh', expected bash, zsh, fish or man"));
}

}  // namespace
}  // namespace metrolux::core::cli
