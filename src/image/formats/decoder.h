#pragma once
#include "image/image_io.h"

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <span>

namespace metrolux::core {

/// Wider or higher images are refused.
inline constexpr int kLargestSide = 1 << 17;

/// An image whose header has been read, and none of its pixels: the reader can still refuse its size. Each
/// format has one file in this folder, and the only code that knows its library.
class ImageDecoder {
  public:
    virtual ~ImageDecoder() = default;
    const ImageInfo& info() const { return info_; }
    bool isFloat() const { return isFloat_; }
    /// Bytes of a value of a channel, once decompressed.
    int valueBytes() const { return valueBytes_; }

    /// All channels, interleaved, row by row from the top. Integers are scaled to [0, 1] and not made linear.
    /// Called once. Throws Error, which says what is wrong and not in which file.
    virtual std::vector<float> readPixels() = 0;

  protected:
    ImageInfo info_;
    bool isFloat_ = false;
    int valueBytes_ = 1;
};

/// Each reads the header at the start of a stream, which must live as long as the result. They throw Error
/// like readPixels.
std::unique_ptr<ImageDecoder> openExr(std::istream& stream);
std::unique_ptr<ImageDecoder> openPng(std::istream& stream);
std::unique_ptr<ImageDecoder> openJpeg(std::istream& stream);
std::unique_ptr<ImageDecoder> openTiff(std::istream& stream);
std::unique_ptr<ImageDecoder> openHdr(std::istream& stream);
std::unique_ptr<ImageDecoder> openBmp(std::istream& stream);
std::unique_ptr<ImageDecoder> openTga(std::istream& stream);
std::unique_ptr<ImageDecoder> openPnm(std::istream& stream);

/// Names of 1 to 4 channels: gray, gray and alpha, RGB, RGB and alpha.
std::vector<std::string> defaultChannels(int count);
/// Integers to [0, 1].
std::vector<float> scaledToOne(std::span<const uint8_t> values);
std::vector<float> scaledToOne(std::span<const uint16_t> values);

/// The next byte. Throws Error if the stream ends before.
uint8_t readByte(std::istream& stream);
/// The next `count` bytes. Throws Error if the stream ends before.
std::string readBytes(std::istream& stream, size_t count);
/// Everything from here to the end.
std::string readRest(std::istream& stream);

}  // namespace metrolux::core
