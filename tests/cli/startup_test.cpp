/// What is loaded before a command does anything: libraries cost time in each of them.

#include "command.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace metrolux::core::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

class StartupTest : public CliTest {
  protected:
    /// The libraries that the dynamic linker finds for the program, one a line.
    std::string libraries() const {
        return Command(folder, {"--version"}, {"env", "LD_TRACE_LOADED_OBJECTS=1"}).wait().out;
    }
};

/// Debian's OpenImageIO alone had loaded 250, and took 0.2 s.
TEST_F(StartupTest, FewLibrariesAreLoaded) {
    const std::string list = libraries();
    EXPECT_THAT(list, HasSubstr("libembree"));
    EXPECT_LT(std::count(list.begin(), list.end(), '\n'), 50) << list;
}

TEST_F(StartupTest, MpiIsLoadedWhereALauncherSaysSo) { EXPECT_THAT(libraries(), Not(HasSubstr("libmpi"))); }

}  // namespace
}  // namespace metrolux::core::cli
