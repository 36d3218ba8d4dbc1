#include "io/volume_file.h"

#include "base/error.h"
#include "io/lfs_pointer.h"

#include <Imath/half.h>

#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <limits>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "the format is little-endian");

constexpr uint64_t kHeaderBytes = 48;

enum class Encoding : int32_t { Float32 = 1, Float16 = 2, UInt8 = 3, Directions = 4 };

uint64_t bytesOf(Encoding encoding) {
    return encoding == Encoding::Float32 ? 4 : encoding == Encoding::Float16 ? 2 : 1;
}

/// What a file begins with, checked.
struct Header {
    Encoding encoding = Encoding::Float32;
    VolumeFile volume;   ///< without values
    uint64_t count = 0;  ///< of values
};

Header readHeader(const fs::path& file, std::istream& stream, uint64_t fileBytes) {
    std::array<char, kHeaderBytes> bytes{};
    if (fileBytes < bytes.size() || !stream.read(bytes.data(), bytes.size()))
        throw Error("{}: has {} bytes, expected a header of {} at least", file.string(), fileBytes,
                    kHeaderBytes);
    if (std::memcmp(bytes.data(), "VOL", 3) != 0)
        throw Error("{}: begins with \"{}\", expected \"VOL\"", file.string(), std::string(bytes.data(), 3));
    if (bytes[3] != 3)
        throw Error("{}: version {} of the format, expected 3", file.string(),
                    static_cast<int>(static_cast<unsigned char>(bytes[3])));
    std::array<int32_t, 5> numbers{};
    std::memcpy(numbers.data(), bytes.data() + 4, sizeof(numbers));
    std::array<float, 6> box{};
    std::memcpy(box.data(), bytes.data() + 24, sizeof(box));

    Header header;
    header.encoding = static_cast<Encoding>(numbers[0]);
    if (header.encoding == Encoding::Directions)
        throw Error(
            "{}: encoding 4, directions of fibers, which no phase function here takes; expected 1 (32 bit "
            "floats), 2 (16 bit floats) or 3 (bytes)",
            file.string());
    if (numbers[0] < 1 || numbers[0] > 4)
        throw Error("{}: encoding {}, expected 1 (32 bit floats), 2 (16 bit floats) or 3 (bytes)",
                    file.string(), numbers[0]);
    header.volume.samples.resolution = {numbers[1], numbers[2], numbers[3]};
    header.volume.samples.channels = numbers[4];
    if (numbers[4] == 6)
        throw Error(
            "{}: 6 channels, parameters of microflakes, which no phase function here takes; expected 1 "
            "or 3",
            file.string());
    if (numbers[4] != 1 && numbers[4] != 3)
        throw Error("{}: {} channels, expected 1 or 3", file.string(), numbers[4]);
    header.volume.box = {{double(box[0]), double(box[1]), double(box[2])},
                         {double(box[3]), double(box[4]), double(box[5])}};

    const uint64_t left = (fileBytes - kHeaderBytes) / bytesOf(header.encoding);
    header.count = static_cast<uint64_t>(numbers[4]);
    bool fits = true;
    for (int a = 0; a < 3; ++a) {
        const int n = header.volume.samples.resolution[a];
        if (n < 1)
            throw Error("{}: {} cells along axis {}, expected one at least", file.string(), n, "xyz"[a]);
        fits = fits && header.count <= left / static_cast<uint64_t>(n);
        if (fits) header.count *= static_cast<uint64_t>(n);
    }
    if (!fits || kHeaderBytes + header.count * bytesOf(header.encoding) != fileBytes)
        throw Error(
            "{}: is {}: {} x {} x {} cells of {} channels with {} bytes each were expected after the header, "
            "the file has {} bytes",
            file.string(), fits ? "too long" : "truncated", numbers[1], numbers[2], numbers[3], numbers[4],
            bytesOf(header.encoding), fileBytes);
    return header;
}

/// `count` values in any encoding, to `target`.
void readValues(std::istream& stream, Encoding encoding, uint64_t count, float* target) {
    if (encoding == Encoding::Float32) {
        stream.read(reinterpret_cast<char*>(target), static_cast<std::streamsize>(count * sizeof(float)));
        return;
    }
    std::array<unsigned char, 8192> buffer{};
    const uint64_t each = bytesOf(encoding);
    while (count > 0 && stream) {
        const uint64_t piece = std::min<uint64_t>(count, buffer.size() / each);
        stream.read(reinterpret_cast<char*>(buffer.data()), static_cast<std::streamsize>(piece * each));
        for (uint64_t i = 0; i < piece; ++i) {
            if (encoding == Encoding::UInt8) {
                *target++ = static_cast<float>(buffer[i]) / 255;
            } else {
                uint16_t bits = 0;
                std::memcpy(&bits, buffer.data() + 2 * i, sizeof(bits));
                *target++ = imath_half_to_float(bits);
            }
        }
        count -= piece;
    }
}

}  // namespace

VolumeFile readVolumeFile(const fs::path& file, MemoryBudget* memory, SampleRange range) {
    refuseLfsPointer(file);
    std::error_code code;
    const uint64_t fileBytes = fs::file_size(file, code);
    std::ifstream stream(file, std::ios::binary);
    if (code || !stream) throw Error("{}: cannot be read", file.string());
    Header header = readHeader(file, stream, fileBytes);
    try {
        if (memory)
            memory->take(header.count * sizeof(float) + gridVolumeBytes(header.volume.samples.resolution),
                         "the volume");
        header.volume.samples.values.resize(header.count, 0.0f);
        readValues(stream, header.encoding, header.count, header.volume.samples.values.data());
        if (!stream) throw Error("cannot be read in full");
        checkSamples(header.volume.samples, range);
    } catch (const Error& error) {
        throw Error("{}: {}", file.string(), error.what());
    }
    return std::move(header.volume);
}

}  // namespace metrolux::core
