#pragma once
#include "image/image_io.h"

#include <cstdint>
#include <span>

namespace metrolux::core {

/// A channel of an image to be written: `stride` floats from one pixel to the next, row by row.
struct EncodedChannel {
    std::string name;
    const float* values = nullptr;
    size_t stride = 1;
};

/// The bytes of an EXR of 32-bit floats with ZIP compression and Rec.709 chromaticities. Throws Error.
std::string encodeExrChannels(int width, int height, const ImagePlace& place,
                              const std::vector<EncodedChannel>& channels, const Metadata& metadata);
/// The bytes of an 8-bit sRGB PNG of interleaved RGB; of the metadata it has the text. Throws Error.
std::string encodePngBytes(int width, int height, std::span<const uint8_t> rgb, const Metadata& metadata);

}  // namespace metrolux::core
