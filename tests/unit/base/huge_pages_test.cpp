#include "base/huge_pages.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace metrolux::core {
namespace {

TEST(HugePageAllocator, ArraysOfAnySizeBeginAtACacheLineAndHoldWhatIsWritten) {
    for (const size_t n :
         {size_t{1}, size_t{1000}, (size_t{1} << 19) - 1, size_t{1} << 19, size_t{1500007}}) {
        std::vector<uint32_t, HugePageAllocator<uint32_t>> v(n);
        EXPECT_EQ(reinterpret_cast<uintptr_t>(v.data()) % 64, 0u);
        std::iota(v.begin(), v.end(), 7u);
        const auto copy = v;
        v.resize(2 * n);  // moves to memory of another size
        EXPECT_TRUE(std::equal(copy.begin(), copy.end(), v.begin()));
        EXPECT_EQ(v[n - 1], 6 + n);
    }
}

TEST(PreferHugePages, ArraysStayWhatAndWhereTheyAre) {
    for (const size_t n : {size_t{0}, size_t{1000}, size_t{1} << 19, size_t{3000017}}) {
        std::vector<uint32_t> v(n), expected(n);
        std::iota(v.begin(), v.end(), 7u);
        std::iota(expected.begin(), expected.end(), 7u);
        const uint32_t* const place = v.data();
        preferHugePages(v.data(), n * sizeof(uint32_t));
        EXPECT_EQ(v.data(), place);
        EXPECT_EQ(v, expected);
    }
}

}  // namespace
}  // namespace metrolux::core
