#include "base/memory_budget.h"

#include "base/error.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

TEST(MemoryBudget, RefusesWhatDoesNotFitAndSaysWhat) {
    MemoryBudget memory(3 << 20);
    memory.take(1 << 20, "the image");
    EXPECT_NO_THROW(memory.require(2 << 20, "the mesh"));
    EXPECT_EQ(memory.left(), uint64_t{2} << 20) << "required, not taken";
    try {
        memory.take((2 << 20) + 1, "the mesh");
        FAIL() << "not refused";
    } catch (const Error& error) {
        EXPECT_STREQ(
            error.what(),
            "the mesh would take 2.0 MiB of memory, expected at most 2.0 MiB (1.0 MiB of 3.0 MiB are in "
            "use)");
    }
    EXPECT_EQ(memory.left(), uint64_t{2} << 20) << "nothing is booked for what is refused";
    memory.take(2 << 20, "the mesh");
    EXPECT_THROW(memory.take(1, "more"), Error);
    EXPECT_THROW(memory.take(~uint64_t{0}, "a sum that would overflow"), Error);
}

TEST(MemoryBudget, UnlimitedTakesAnything) {
    MemoryBudget memory = MemoryBudget::unlimited();
    EXPECT_NO_THROW(memory.take(uint64_t{1} << 62, "half of everything"));
}

TEST(MemoryBudget, SizesAreReadable) {
    EXPECT_EQ(sizeText(1023), "1023 bytes");
    EXPECT_EQ(sizeText(1536), "1.5 KiB");
    EXPECT_EQ(sizeText(uint64_t{32} << 30), "32.0 GiB");
    EXPECT_EQ(sizeText(~uint64_t{0}), "16.0 EiB");
}

TEST(MemoryBudget, TheMachineHasMemory) { EXPECT_GT(physicalMemoryBytes(), uint64_t{1} << 20); }

}  // namespace
}  // namespace metrolux::core
