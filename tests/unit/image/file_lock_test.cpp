#include "image/file_lock.h"

#include "base/error.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

namespace metrolux::core {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

/// The message of the error, or nothing where there is none.
std::string refusal(const fs::path& file) {
    try {
        const FileLock lock("output 'a.exr'", file);
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

TEST(FileLock, TheSecondIsToldWhoHasIt) {
    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "a.exr";
    {
        const FileLock first("output 'a.exr'", file);
        EXPECT_THAT(refusal(file), HasSubstr(fmt::format("output 'a.exr' is being written by another process "
                                                         "(process {})",
                                                         ::getpid())));
        EXPECT_EQ(refusal(folder.path() / "b.exr"), "");
        fs::create_symlink(file, folder.path() / "link.exr");
        EXPECT_NE(refusal(folder.path() / "link.exr"), "");
    }
    EXPECT_EQ(refusal(file), "");
    fs::remove(folder.path() / "link.exr");
    EXPECT_TRUE(fs::is_empty(folder.path())) << "nothing is left behind";
}

TEST(FileLock, AProcessThatIsKilledHasItNoLonger) {
    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "a.exr";
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    const pid_t child = ::fork();
    if (child == 0) {
        const FileLock lock("output", file);
        (void)!::write(ready[1], "x", 1);
        ::pause();
    }
    char byte = 0;
    ASSERT_EQ(::read(ready[0], &byte, 1), 1);
    EXPECT_NE(refusal(file), "");
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_EQ(refusal(file), "");
    ::close(ready[0]);
    ::close(ready[1]);
}

TEST(FileLock, WhereNothingCanBeCreatedThereIsNone) { EXPECT_EQ(refusal("/no/such/folder/a.exr"), ""); }

}  // namespace
}  // namespace metrolux::core
