#include "image/hilbert_order.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace metrolux::core {

namespace {

/// Distance along the Hilbert curve that fills a 2^order square (the classic quadrant walk).
uint64_t hilbertDistance(int order, uint32_t x, uint32_t y) {
    uint64_t d = 0;
    for (uint32_t s = 1u << (order - 1); s > 0; s >>= 1) {
        const uint32_t rx = (x & s) ? 1 : 0, ry = (y & s) ? 1 : 0;
        d += uint64_t(s) * s * ((3 * rx) ^ ry);
        if (ry == 0) {
            if (rx == 1) {
                x = (s - 1) - (x & (s - 1));
                y = (s - 1) - (y & (s - 1));
            }
            std::swap(x, y);
        }
        x &= s - 1;
        y &= s - 1;
    }
    return d;
}

}  // namespace

std::vector<uint32_t> hilbertOrder(int width, int height) {
    const int order =
        std::max(1, static_cast<int>(std::bit_width(static_cast<uint32_t>(std::max(width, height) - 1))));
    std::vector<std::pair<uint64_t, uint32_t>> keyed;
    keyed.reserve(size_t(width) * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            keyed.emplace_back(hilbertDistance(order, x, y), static_cast<uint32_t>(y * width + x));
    std::sort(keyed.begin(), keyed.end());
    std::vector<uint32_t> result;
    result.reserve(keyed.size());
    for (const auto& [distance, pixel] : keyed) result.push_back(pixel);
    return result;
}

}  // namespace metrolux::core
