#pragma once
/// Packets for tev (github.com/Tom94/tev), as its src/Ipc.cpp reads them: a length of 32 bits that counts
/// itself, a byte for the type, then the fields; numbers are little endian, strings end with a zero.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace metrolux::core::view {

/// An image of this size with channels R, G, B.
std::string tevCreateImage(const std::string& name, int width, int height);
/// Rows of it from `y` on: 3 floats a pixel.
std::string tevUpdateImage(const std::string& name, int y, int width, int height,
                           std::span<const float> pixels);
std::string tevCloseImage(const std::string& name);

}  // namespace metrolux::core::view
