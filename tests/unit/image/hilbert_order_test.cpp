#include "image/hilbert_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace metrolux::core {
namespace {

TEST(HilbertOrder, VisitsEveryPixelOnce) {
    for (const auto& [w, h] :
         {std::pair(1, 1), std::pair(1, 7), std::pair(16, 16), std::pair(33, 5), std::pair(640, 2)}) {
        const std::vector<uint32_t> order = hilbertOrder(w, h);
        EXPECT_EQ(order.size(), size_t(w) * h);
        EXPECT_EQ(std::set<uint32_t>(order.begin(), order.end()).size(), order.size());
        EXPECT_EQ(*std::max_element(order.begin(), order.end()), uint32_t(w * h - 1));
    }
}

TEST(HilbertOrder, GoesFromNeighborToNeighborInSquares) {
    for (const int size : {2, 4, 8, 64, 128}) {
        const std::vector<uint32_t> order = hilbertOrder(size, size);
        for (size_t i = 1; i < order.size(); ++i) {
            const int ax = order[i] % size, ay = order[i] / size, bx = order[i - 1] % size,
                      by = order[i - 1] / size;
            ASSERT_EQ(std::abs(ax - bx) + std::abs(ay - by), 1) << size << " at " << i;
        }
    }
}

}  // namespace
}  // namespace metrolux::core
