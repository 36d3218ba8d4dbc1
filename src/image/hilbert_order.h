#pragma once
#include <cstdint>
#include <vector>

namespace metrolux::core {

/// Order of the pixels of a width x height window along a Hilbert curve: a small step in the curve's
/// parameter is a near pixel.
std::vector<uint32_t> hilbertOrder(int width, int height);

}  // namespace metrolux::core
