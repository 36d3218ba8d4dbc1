/// Mitsuba's grids (.vol): what is read, what is refused.

#include "io/volume_file.h"

#include "support.h"

#include <Imath/half.h>
#include <gmock/gmock.h>

#include <cstring>

namespace metrolux::core::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

template <class T>
std::string bytesOf(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}
std::string header(int encoding, const Imath::V3i& n, int channels) {
    return "VOL\x03" + bytesOf<int32_t>({encoding, n.x, n.y, n.z, channels}) +
           bytesOf<float>({-1, -2, -3, 4, 5, 6});
}
VolumeFile volume(const std::string& bytes, uint64_t memoryBytes = 1 << 20) {
    const TemporaryFolder folder;
    MemoryBudget memory(memoryBytes);
    return readVolumeFile(folder.write("grid.vol", bytes), &memory);
}
std::string refusal(const std::string& bytes, uint64_t memoryBytes = 1 << 20) {
    return errorOf([&] { volume(bytes, memoryBytes); });
}
std::vector<float> valuesOf(const VolumeFile& file) {
    return {file.samples.values.begin(), file.samples.values.end()};
}

TEST(VolumeFile, readsEveryEncoding) {
    const VolumeFile floats = volume(header(1, {2, 1, 3}, 1) + bytesOf<float>({0, 1, 2.5f, 3, 4, 1e6f}));
    EXPECT_EQ(floats.samples.resolution, Imath::V3i(2, 1, 3));
    EXPECT_EQ(floats.samples.channels, 1);
    EXPECT_THAT(valuesOf(floats), ElementsAre(0, 1, 2.5f, 3, 4, 1e6f));
    EXPECT_EQ(floats.box.min, Vec3d(-1, -2, -3));
    EXPECT_EQ(floats.box.max, Vec3d(4, 5, 6));

    const VolumeFile bytes = volume(header(3, {1, 1, 1}, 3) + std::string("\x00\x33\xff", 3));
    EXPECT_EQ(bytes.samples.channels, 3);
    EXPECT_THAT(valuesOf(bytes), ElementsAre(0, 0.2f, 1));

    const VolumeFile halves = volume(header(2, {2, 1, 1}, 1) +
                                     bytesOf<uint16_t>({Imath::half(0.5f).bits(), Imath::half(3.0f).bits()}));
    EXPECT_THAT(valuesOf(halves), ElementsAre(0.5f, 3));
}

TEST(VolumeFile, longFilesOfShortNumbersAreReadInPieces) {
    std::string bytes = header(3, {101, 103, 7}, 3);
    for (int i = 0; i < 101 * 103 * 7 * 3; ++i) bytes += static_cast<char>(i % 251);
    const VolumeFile file = volume(bytes);
    for (size_t i = 0; i < file.samples.values.size(); ++i)
        ASSERT_EQ(file.samples.values[i], static_cast<float>(i % 251) / 255) << i;
}

TEST(VolumeFile, placesSamplesInTheOrderOfTheFile) {
    std::vector<float> values;
    for (int i = 0; i < 24; ++i) values.push_back(static_cast<float>(i));
    const VolumePtr grid = makeGridVolume(volume(header(1, {2, 3, 4}, 1) + bytesOf(values)).samples,
                                          {.filter = GridFilter::Nearest});
    EXPECT_EQ(grid->value({0.75f, 0.1f, 0.1f}).x, 1);
    EXPECT_EQ(grid->value({0.25f, 0.5f, 0.1f}).x, 2);
    EXPECT_EQ(grid->value({0.25f, 0.1f, 0.9f}).x, 18);
}

TEST(VolumeFile, refusals) {
    const std::string data = bytesOf<float>({0, 1, 2, 3, 4, 5});
    EXPECT_THAT(refusal(""), HasSubstr("grid.vol: has 0 bytes, expected a header of 48"));
    EXPECT_THAT(refusal(header(1, {2, 1, 3}, 1).substr(0, 47)), HasSubstr("grid.vol: has 47 bytes"));
    EXPECT_THAT(refusal("PNG" + header(1, {2, 1, 3}, 1).substr(3) + data), HasSubstr("begins with \"PNG\""));
    std::string version = header(1, {2, 1, 3}, 1) + data;
    version[3] = 2;
    EXPECT_THAT(refusal(version), HasSubstr("grid.vol: version 2 of the format, expected 3"));
    EXPECT_THAT(refusal(header(4, {2, 1, 3}, 3) + data), HasSubstr("encoding 4, directions"));
    EXPECT_THAT(refusal(header(0, {2, 1, 3}, 1) + data), HasSubstr("encoding 0, expected 1"));
    EXPECT_THAT(refusal(header(-5, {2, 1, 3}, 1) + data), HasSubstr("encoding -5, expected 1"));
    EXPECT_THAT(refusal(header(1, {2, 1, 3}, 6) + data), HasSubstr("6 channels, parameters of microflakes"));
    EXPECT_THAT(refusal(header(1, {2, 1, 3}, 2) + data), HasSubstr("2 channels, expected 1 or 3"));
    EXPECT_THAT(refusal(header(1, {2, 0, 3}, 1) + data), HasSubstr("0 cells along axis y"));
    EXPECT_THAT(refusal(header(1, {2, 1, -3}, 1) + data), HasSubstr("-3 cells along axis z"));
    EXPECT_THAT(refusal(header(1, {2, 1, 4}, 1) + data), HasSubstr("is truncated: 2 x 1 x 4 cells"));
    EXPECT_THAT(refusal(header(1, {2, 1, 2}, 1) + data), HasSubstr("is too long"));
    EXPECT_THAT(refusal(header(1, {2, 1, 3}, 1) + data.substr(1)), HasSubstr("is truncated"));
    // 10^12 cells, and more than 64 bits count.
    EXPECT_THAT(refusal(header(3, Imath::V3i(10000), 1) + data), HasSubstr("is truncated: 10000 x 10000"));
    EXPECT_THAT(refusal(header(1, Imath::V3i(2147483647), 3) + data),
                HasSubstr("is truncated: 2147483647 x"));
    for (const float bad : {-1.0f, kInfinity, std::numeric_limits<float>::quiet_NaN()})
        EXPECT_THAT(refusal(header(1, {1, 2, 3}, 1) + bytesOf<float>({0, 1, 2, bad, 4, 5})),
                    testing::ContainsRegex("grid.vol: .*in cell \\(0, 1, 1\\)"));
    EXPECT_THAT(refusal(header(1, {2, 1, 3}, 1) + data, 40), HasSubstr("grid.vol: "));
    EXPECT_THAT(refusal("version https://git-lfs.github.com/spec/v1\n"), HasSubstr("pointer of Git LFS"));
    EXPECT_THAT(errorOf([] { readVolumeFile("/nowhere/grid.vol"); }),
                HasSubstr("/nowhere/grid.vol: cannot be read"));
}

}  // namespace
}  // namespace metrolux::core::test
