#include "image/image_io.h"

#include "base/error.h"
#include "base/parallel.h"
#include "image/atomic_file.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ImageIo : public testing::Test {
  protected:
    static ImageData gradient(int width, int height) {
        ImageData image{width, height, 3, {}};
        for (int i = 0; i < width * height * 3; ++i)
            image.pixels.push_back(std::exp2(static_cast<float>(i % 60) - 40));
        return image;
    }
    std::string errorOf(const fs::path& file) const {
        try {
            readImage(file, false);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
    size_t fileCount() const {
        return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }
    test::TemporaryFolder temporary_;
    const fs::path folder = temporary_.path();
};

TEST_F(ImageIo, ExrRoundTripIsExact) {
    ImageData image = gradient(7, 5);
    image.pixels[3] = -1.5f;
    ImageLayer albedo{"albedo", {"R", "G", "B"}, image.pixels};
    ImageLayer depth{"depth", {"Z"}, std::vector<float>(35, 3.25f)};
    depth.pixels[34] = 7;
    const Metadata metadata{{"metrolux:integrator", std::string("mcmc_vcm")},
                            {"metrolux:seconds", 12.5},
                            {"metrolux:passes", 42}};
    writeExr(folder / "a.exr", image, {albedo, depth}, metadata);

    const ImageData read = readImage(folder / "a.exr", false);
    EXPECT_EQ(read.width, 7);
    EXPECT_EQ(read.height, 5);
    EXPECT_EQ(read.channels, 3);
    EXPECT_EQ(read.pixels, image.pixels);

    const ImageLayer readAlbedo = readLayer(folder / "a.exr", "albedo");
    // The file orders channels by name; their names say which is which.
    ASSERT_EQ(readAlbedo.channels.size(), 3u);
    for (size_t c = 0; c < 3; ++c) {
        const size_t original = std::string("RGB").find(readAlbedo.channels[c]);
        for (size_t i = 0; i < 35; ++i)
            EXPECT_EQ(readAlbedo.pixels[3 * i + c], image.pixels[3 * i + original]);
    }
    EXPECT_EQ(readLayer(folder / "a.exr", "depth").pixels, depth.pixels);
    EXPECT_THROW(readLayer(folder / "a.exr", "normal"), Error);

    const Metadata readBack = readMetadata(folder / "a.exr");
    for (const auto& entry : metadata) EXPECT_THAT(readBack, testing::Contains(entry)) << entry.first;
    EXPECT_EQ(fileCount(), 1u) << "no temporary file may stay";
}

TEST_F(ImageIo, PngRoundTripWithinHalfAStep) {
    ImageData image{16, 16, 3, {}};
    for (int i = 0; i < 768; ++i) image.pixels.push_back(static_cast<float>(i) / 767);
    writePng(folder / "a.png", image);
    const ImageData linear = readImage(folder / "a.png", false), raw = readImage(folder / "a.png", true);
    ASSERT_EQ(linear.pixels.size(), image.pixels.size());
    for (size_t i = 0; i < image.pixels.size(); ++i) {
        EXPECT_NEAR(raw.pixels[i], encodeSrgb(image.pixels[i]), 0.5 / 255 + 1e-5);
        EXPECT_NEAR(linear.pixels[i], decodeSrgb(raw.pixels[i]), 1e-6);
    }
}

TEST_F(ImageIo, PngClampsAndExposes) {
    const ImageData image{2, 1, 3, {-1, 0.25f, 100, kInfinity, std::numeric_limits<float>::quiet_NaN(), 0}};
    writePng(folder / "a.png", image, 1);
    const ImageData raw = readImage(folder / "a.png", true);
    EXPECT_EQ(raw.pixels[0], 0);
    EXPECT_NEAR(raw.pixels[1], encodeSrgb(0.5f), 0.5 / 255);
    EXPECT_EQ(raw.pixels[2], 1);
    EXPECT_EQ(raw.pixels[3], 1);
    EXPECT_EQ(raw.pixels[4], 0);
}

/// A file written byte by byte, so that the reader is not tested against the writer of the same library.
void writeBytes(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

TEST_F(ImageIo, TgaKeepsGrayAndAlpha) {
    const auto header = [](char type, char width, char height, char bits, char descriptor) {
        return std::string{0, 0, type, 0, 0, 0, 0, 0, 0, 0, 0, 0, width, 0, height, 0, bits, descriptor};
    };
    writeBytes(folder / "gray.tga", header(3, 2, 1, 8, 0x20) + std::string{'\x00', '\xff'});
    const ImageData gray = readImage(folder / "gray.tga", false);
    EXPECT_EQ(gray.channels, 1);
    EXPECT_EQ(gray.pixels, (std::vector<float>{0, 1}));

    // Blue, green, red, alpha: the color must not be multiplied by alpha, nor alpha decoded.
    writeBytes(folder / "alpha.tga", header(2, 1, 1, 32, 0x28) + std::string{'\xff', '\x80', '\x00', '\x80'});
    const ImageData alpha = readImage(folder / "alpha.tga", false);
    ASSERT_EQ(alpha.channels, 4);
    EXPECT_FLOAT_EQ(alpha.pixels[0], 0);
    EXPECT_NEAR(alpha.pixels[1], decodeSrgb(128 / 255.0f), 1e-5);
    EXPECT_FLOAT_EQ(alpha.pixels[2], 1);
    EXPECT_NEAR(alpha.pixels[3], 128 / 255.0f, 1e-5);
}

TEST_F(ImageIo, BmpPaletteIsExpanded) {
    // 2x1 pixels, 8 bits, palette of two colors (blue, green, red, 0): red and green.
    std::string bytes = "BM";
    const auto word = [&](uint32_t value, int size) {
        for (int i = 0; i < size; ++i) bytes.push_back(static_cast<char>(value >> (8 * i)));
    };
    word(14 + 40 + 8 + 4, 4), word(0, 4), word(14 + 40 + 8, 4);
    word(40, 4), word(2, 4), word(1, 4), word(1, 2), word(8, 2), word(0, 4), word(4, 4);
    word(2835, 4), word(2835, 4), word(2, 4), word(0, 4);
    word(0x00ff0000, 4), word(0x0000ff00, 4);
    word(0x00000100, 4);
    writeBytes(folder / "a.bmp", bytes);
    const ImageData image = readImage(folder / "a.bmp", false);
    EXPECT_EQ(image.channels, 3);
    EXPECT_EQ(image.pixels, (std::vector<float>{1, 0, 0, 0, 1, 0}));
}

TEST_F(ImageIo, ErrorsNameTheFile) {
    EXPECT_THAT(errorOf(folder / "absent.png"), HasSubstr("absent.png"));
    EXPECT_THAT(errorOf(folder), HasSubstr("folder"));
    writeBytes(folder / "junk.exr", "this is not an image");
    EXPECT_THAT(errorOf(folder / "junk.exr"), HasSubstr("junk.exr"));
    writeBytes(folder / "empty.jpg", "");
    EXPECT_THAT(errorOf(folder / "empty.jpg"), HasSubstr("empty.jpg"));

    writeExr(folder / "whole.exr", gradient(64, 64));
    const auto size = fs::file_size(folder / "whole.exr");
    fs::copy(folder / "whole.exr", folder / "cut.exr");
    fs::resize_file(folder / "cut.exr", size / 2);
    EXPECT_THAT(errorOf(folder / "cut.exr"), HasSubstr("cut.exr"));
}

TEST_F(ImageIo, ClaimedSizeIsCheckedBeforeMemoryIsTaken) {
    // A TGA header that claims 65535 x 65535 pixels of 4 channels, with no data.
    std::string header{0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, '\xff', '\xff', '\xff', '\xff', 32, 0x28};
    writeBytes(folder / "huge.tga", header);
    EXPECT_THAT(errorOf(folder / "huge.tga"), HasSubstr("huge.tga"));
}

TEST_F(ImageIo, WritingFailsWithoutTrace) {
    const ImageData image = gradient(4, 4);
    EXPECT_THROW(writeExr(folder / "absent" / "a.exr", image), Error);
    fs::create_directory(folder / "a.exr");
    EXPECT_THROW(writeExr(folder / "a.exr", image), Error);
    EXPECT_THROW(writeExr(folder / "b.exr", image, {{"depth", {"Z"}, {1, 2}}}), Error);
    EXPECT_THROW(writePng(folder / "b.png", ImageData{4, 4, 1, std::vector<float>(16)}), Error);
    EXPECT_EQ(fileCount(), 1u);
    EXPECT_THROW(checkWritable(folder), Error);
    EXPECT_NO_THROW(checkWritable(folder / "c.exr"));
    EXPECT_EQ(fileCount(), 1u);
}

TEST_F(ImageIo, ReplacesAnExistingFileAsAWhole) {
    writeFile(folder / "a.json", "old and long");
    writeFile(folder / "a.json", "new");
    std::ifstream stream(folder / "a.json");
    std::string text;
    std::getline(stream, text);
    EXPECT_EQ(text, "new");
    {
        AtomicFile abandoned(folder / "a.json");
        abandoned.write("half");
    }
    EXPECT_EQ(fs::file_size(folder / "a.json"), 3u);
    EXPECT_EQ(fileCount(), 1u);
}

TEST_F(ImageIo, ReadsInParallel) {
    const ImageData image = gradient(32, 32);
    writeExr(folder / "a.exr", image);
    std::atomic<int> wrong{0};
    parallelFor(32, [&](size_t) { wrong += readImage(folder / "a.exr", false).pixels != image.pixels; });
    EXPECT_EQ(wrong, 0);
}

TEST(Tonemap, SrgbIsItsOwnInverseAndMonotone) {
    for (int i = 0; i <= 255; ++i) {
        const float encoded = static_cast<float>(i) / 255;
        EXPECT_NEAR(encodeSrgb(decodeSrgb(encoded)), encoded, 1e-5);
    }
    EXPECT_NEAR(encodeSrgb(0.2140f), 0.5f, 1e-3);  // IEC 61966-2-1
    float last = -1;
    for (float x = 0; x < 40; x += 0.01f) {
        const float y = filmicCurve(x);
        EXPECT_GE(y, last);
        EXPECT_LE(y, 1);
        last = y;
    }
    EXPECT_EQ(filmicCurve(0), 0);
    EXPECT_NEAR(filmicCurve(1), 0.8038, 1e-3);
    EXPECT_EQ(filmicCurve(kInfinity), 1);
}

TEST(Tonemap, NamesOfCurves) {
    EXPECT_EQ(toneCurveFromName("srgb"), ToneCurve::Srgb);
    EXPECT_EQ(toneCurveFromName("filmic"), ToneCurve::Filmic);
    EXPECT_EQ(toneCurveFromName("aces"), std::nullopt);
}

/// A process was killed after it had kept the old file by its second name, before the new one was there.
TEST_F(ImageIo, ThePreviousFileIsKeptWhereItIsKeptAlready) {
    const auto write = [&](const char* text) {
        AtomicFile file(folder / "c");
        file.write(text);
        file.commit(folder / "c.1");
    };
    const auto content = [&](const char* name) {
        std::string text;
        std::getline(std::ifstream(folder / name), text);
        return text;
    };
    write("one");
    EXPECT_EQ(fileCount(), 1u);
    fs::create_hard_link(folder / "c", folder / "c.1");
    write("two");
    EXPECT_EQ(content("c"), "two");
    EXPECT_EQ(content("c.1"), "one");
    EXPECT_EQ(fileCount(), 2u) << "and nothing else";
    write("three");
    EXPECT_EQ(content("c.1"), "two");
    EXPECT_EQ(fileCount(), 2u);
}

}  // namespace
}  // namespace metrolux::core
