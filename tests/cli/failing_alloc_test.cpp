/// Allocations that fail in turn (support/failing_alloc.cpp): from loading the scene to the image.

#include "command.h"
#include "image/image_io.h"
#include "paths.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>

namespace metrolux::core::cli {
namespace {

using testing::AnyOf;

class FailingAllocTest : public CliTest {
  protected:
    Outcome runFailing(long call, const std::string& integrator) const {
        const Words environment{
            "env", std::string("LD_PRELOAD=") + METROLUX_BINARY_DIR + "/tests/libfailing_alloc.so",
            "FAILING_ALLOC_FILE=scene.xml", fmt::format("FAILING_ALLOC_CALL={}", call),
            "FAILING_ALLOC_LOG=count"};
        return Command(folder,
                       {"render", "scene.xml", "-i", integrator, "--passes", "1", "--threads", "1",
                        "--resolution", "8x6", "-o", "a.exr", "--checkpoint", "c"},
                       environment)
            .wait();
    }
    /// By environment, each of so many: METROLUX_ALLOCATIONS=1 tries them all, which takes an hour.
    static long step(long calls) {
        const char* every = std::getenv("METROLUX_ALLOCATIONS");
        constexpr long kTried = 60;
        return every ? std::max(1L, std::atol(every)) : std::max(1L, calls / kTried);
    }
};

TEST_F(FailingAllocTest, EachEndsWithStatus2AndOneLineOrIsRecoveredFrom) {
    for (const char* integrator : {"mcmc_vcm", "path"}) {
        const Outcome whole = runFailing(0, integrator);
        ASSERT_EQ(whole.status, 0) << whole.err;
        long calls = 0;
        std::ifstream(folder / "count") >> calls;
        ASSERT_GT(calls, 1000) << "the library was not loaded";
        const std::vector<float> expected = pixels("a.exr");
        std::map<int, int> statuses;
        // A step that has no factor in common with what repeats.
        for (long call = 1; call <= calls; call += step(calls) | 1) {
            SCOPED_TRACE(fmt::format("allocation {} of {}", call, calls));
            const Outcome outcome = runFailing(call, integrator);
            ++statuses[outcome.status];
            ASSERT_THAT(outcome.status, AnyOf(0, 2, 4)) << outcome.err;
            // What was there is whole.
            EXPECT_EQ(pixels("a.exr"), expected);
            if (outcome.status != 2) continue;
            const size_t last = outcome.err.rfind("metrolux: ");
            ASSERT_NE(last, std::string::npos) << outcome.err;
            EXPECT_EQ(
                std::count(outcome.err.begin() + static_cast<std::ptrdiff_t>(last), outcome.err.end(), '\n'),
                1)
                << outcome.err;
        }
        std::string text;
        for (const auto& [status, count] : statuses) text += fmt::format(" {}: {}", status, count);
        std::printf("%s: %ld allocations; runs by status:%s\n", integrator, calls, text.c_str());
    }
}

}  // namespace
}  // namespace metrolux::core::cli
