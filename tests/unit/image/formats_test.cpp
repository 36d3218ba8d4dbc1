/// Readers of image formats: files of other programs, and files written here byte by byte.

#include "base/error.h"
#include "image/image_io.h"
#include "paths.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Bytes = std::string;
using Floats = std::vector<float>;

/// FNV-1a of the bits, four bytes at a time.
uint64_t hashOf(const Floats& values) {
    uint64_t hash = 1469598103934665603u;
    for (const float value : values) hash = (hash ^ std::bit_cast<uint32_t>(value)) * 1099511628211u;
    return hash;
}

Bytes little(uint32_t value, int size) {
    Bytes bytes;
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<char>(value >> (8 * i)));
    return bytes;
}
Bytes bytesOf(std::initializer_list<int> values) {
    Bytes bytes;
    for (const int value : values) bytes.push_back(static_cast<char>(value));
    return bytes;
}

class Formats : public testing::Test {
  protected:
    ImageData read(const std::string& name, const Bytes& bytes, bool raw = true) const {
        std::ofstream(folder / name, std::ios::binary) << bytes;
        return readImage(folder / name, raw);
    }
    std::string errorOf(const std::string& name, const Bytes& bytes) const {
        try {
            read(name, bytes);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
    /// A file that another program has written; the first byte is the fuzz target's.
    static Bytes corpus(const std::string& name) {
        std::ifstream stream(fs::path(METROLUX_SOURCE_DIR) / "fuzz/corpus/image" / name, std::ios::binary);
        const Bytes bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
        return bytes.substr(1);
    }
    test::TemporaryFolder temporary_;
    const fs::path folder = temporary_.path();
};

TEST_F(Formats, FilesOfOtherProgramsHaveTheValuesThatOpenImageIoReads) {
    const struct {
        const char *file, *name;
        uint64_t raw, linear;
    } kFiles[] = {
        {"bmp", "a.bmp", 0x966a303ff0586355, 0xa8d11f7aa82ce27a},
        {"exr_none", "a.exr", 0x48aa30886452cb24, 0x48aa30886452cb24},
        {"exr_piz", "a.exr", 0x2d4bdf9ef1d02e41, 0x2d4bdf9ef1d02e41},
        {"exr_rle", "a.exr", 0x2d4bdf9ef1d02e41, 0x2d4bdf9ef1d02e41},
        {"exr_tiled", "a.exr", 0x580f7e1ec0c664f3, 0x580f7e1ec0c664f3},
        {"exr_zip", "a.exr", 0xac0ac82fea931db3, 0xac0ac82fea931db3},
        {"hdr", "a.hdr", 0xfb7f2b239c22f213, 0xfb7f2b239c22f213},
        {"pfm", "a.pfm", 0xfe42bb90ac61d34c, 0xfe42bb90ac61d34c},
        {"png_grey", "a.png", 0xb3c7e7d25a49d460, 0x2fb67a0167617c50},
        {"png_rgb", "a.png", 0x966a303ff0586355, 0xa8d11f7aa82ce27a},
        {"png_rgba16", "a.png", 0xc9730a4dc11f2528, 0xdccc6ed0f1982568},
        {"ppm", "a.ppm", 0xbe3d5c5eaaf666e9, 0xfd4e960f1d421fe8},
        {"tga", "a.tga", 0xc2cc0d84834454ee, 0x41be64238067a385},
        {"tga_rle", "a.tga", 0x73ee51bd0a7afc3c, 0x6017b3aca774be79},
        {"tiff_float", "a.tiff", 0xff974fb8b4dcc04a, 0xff974fb8b4dcc04a},
        {"tiff_lzw", "a.tiff", 0xe79133438f8b8c54, 0x39f24be1e043084a},
    };
    for (const auto& f : kFiles) {
        EXPECT_EQ(hashOf(read(f.name, corpus(f.file), true).pixels), f.raw) << f.file;
        EXPECT_EQ(hashOf(read(f.name, corpus(f.file), false).pixels), f.linear) << f.file;
    }
}

TEST_F(Formats, BytesOfMemoryAreReadLikeAFile) {
    for (const char* file : {"exr_zip", "png_rgba16", "jpeg", "tiff_lzw", "hdr", "bmp", "ppm"}) {
        const Bytes bytes = corpus(file);
        EXPECT_EQ(readImageBytes(file, bytes, true).pixels, read("a", bytes).pixels) << file;
    }
}

TEST_F(Formats, AFileThatEndsEarlyIsRefused) {
    for (const char* file : {"exr_none", "exr_piz", "exr_tiled", "png_rgb", "jpeg", "tiff_lzw", "tiff_float",
                             "hdr", "bmp", "ppm", "pfm"})
        for (const size_t share : {size_t{40}, size_t{70}}) {
            const Bytes bytes = corpus(file);
            EXPECT_THAT(errorOf("a", bytes.substr(0, bytes.size() * share / 100)),
                        HasSubstr("cannot read image"))
                << file << " to " << share << " %";
        }
    // TGA ends with a part that nobody needs.
    for (const char* file : {"tga", "tga_rle"})
        for (const size_t size : {size_t{17}, size_t{25}})
            EXPECT_THAT(errorOf("a.tga", corpus(file).substr(0, size)), HasSubstr("ends too early"));
}

TEST_F(Formats, HdrRunsOfComponentsAndOfPixels) {
    const Bytes head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n";
    // Exponent 129: the mantissas are in 1/128.
    const Bytes components =
        bytesOf({2, 2, 0, 8, 128 + 8, 64, 8, 1, 2, 3, 4, 5, 6, 7, 8, 128 + 8, 0, 128 + 8, 129});
    const ImageData image = read("a.hdr", head + components);
    ASSERT_EQ(image.pixels.size(), 24u);
    for (size_t x = 0; x < 8; ++x) {
        EXPECT_EQ(image.pixels[3 * x], 0.5f);
        EXPECT_EQ(image.pixels[3 * x + 1], static_cast<float>(x + 1) / 128);
        EXPECT_EQ(image.pixels[3 * x + 2], 0);
    }
    // A pixel, and the same three times more.
    const ImageData repeated =
        read("b.hdr", "#?RADIANCE\n\n-Y 1 +X 4\n" + bytesOf({128, 64, 32, 129, 1, 1, 1, 3}));
    EXPECT_EQ(repeated.pixels, (Floats{1, 0.5f, 0.25f, 1, 0.5f, 0.25f, 1, 0.5f, 0.25f, 1, 0.5f, 0.25f}));
    EXPECT_THAT(errorOf("c.hdr", head + bytesOf({2, 2, 0, 8, 128 + 9, 64})),
                HasSubstr("longer than its row"));
    EXPECT_THAT(errorOf("d.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n"), HasSubstr("xyze"));
}

TEST_F(Formats, HdrRowsMayComeFromTheBottom) {
    const Bytes pixels = bytesOf({128, 0, 0, 129, 0, 128, 0, 129});
    const ImageData image = read("a.hdr", "#?RADIANCE\n\n+Y 2 +X 1\n" + pixels);
    EXPECT_EQ(image.pixels, (Floats{0, 1, 0, 1, 0, 0}));
}

TEST_F(Formats, PfmInBothOrdersOfBytesFromTheBottom) {
    const auto word = [](float value, bool isBig) {
        Bytes bytes = little(std::bit_cast<uint32_t>(value), 4);
        if (isBig) std::reverse(bytes.begin(), bytes.end());
        return bytes;
    };
    EXPECT_EQ(read("a.pfm", "Pf\n1 2\n-1.0\n" + word(3, false) + word(0.5f, false)).pixels,
              (Floats{0.5f, 3}));
    EXPECT_EQ(read("b.pfm", "Pf\n1 2\n2.0\n" + word(3, true) + word(0.5f, true)).pixels, (Floats{1, 6}));
    EXPECT_THAT(errorOf("c.pfm", "Pf\n1 2\n0\n" + word(3, false)), HasSubstr("scale is '0'"));
}

TEST_F(Formats, PnmInWordsBitsAndWideIntegers) {
    EXPECT_EQ(read("a.pgm", "P2\n# a comment\n2 1\n100\n0 100\n").pixels, (Floats{0, 1}));
    EXPECT_EQ(read("b.pbm", "P1\n3 1\n1 01\n").pixels, (Floats{0, 1, 0}));
    EXPECT_EQ(read("c.pbm", "P4\n3 1\n" + bytesOf({0xa0})).pixels, (Floats{0, 1, 0}));
    const Floats wide = read("d.pgm", "P5\n2 1\n65535\n" + bytesOf({0x80, 0x00, 0xff, 0xff})).pixels;
    ASSERT_EQ(wide.size(), 2u);
    EXPECT_FLOAT_EQ(wide[0], 32768 / 65535.0f);
    EXPECT_EQ(wide[1], 1);
    EXPECT_THAT(errorOf("e.pgm", "P2\n2 1\n100\n0 101\n"), HasSubstr("101, expected 0 to 100"));
    EXPECT_THAT(errorOf("f.pgm", "P2\n2 x\n"), HasSubstr("'x'"));
}

TEST_F(Formats, TgaInRunsWithPaletteFromEitherSide) {
    const auto header = [](int type, int colors, int colorBits, int bits, int descriptor) {
        return bytesOf(
            {0, colors > 0, type, 0, 0, colors, 0, colorBits, 0, 0, 0, 0, 3, 0, 1, 0, bits, descriptor});
    };
    // Twice the second color, then the first; right to left.
    const Bytes palette = bytesOf({0, 0, 255, 255, 0, 0});
    const Bytes runs = bytesOf({0x81, 1, 0x00, 0});
    EXPECT_EQ(read("a.tga", header(9, 2, 24, 8, 0x20) + palette + runs).pixels,
              (Floats{0, 0, 1, 0, 0, 1, 1, 0, 0}));
    EXPECT_EQ(read("b.tga", header(9, 2, 24, 8, 0x30) + palette + runs).pixels,
              (Floats{1, 0, 0, 0, 0, 1, 0, 0, 1}));
    // 5 bits of each color.
    const Floats five =
        read("c.tga", header(2, 0, 0, 16, 0x20) + bytesOf({0x1f, 0x00, 0x00, 0x7c, 0xe0, 0x03})).pixels;
    EXPECT_EQ(five, (Floats{0, 0, 1, 1, 0, 0, 0, 1, 0}));
    EXPECT_THAT(errorOf("d.tga", header(9, 1, 24, 8, 0x20) + palette.substr(0, 3) + runs),
                HasSubstr("has color 1"));
    EXPECT_THAT(errorOf("e.tga", header(5, 0, 0, 24, 0)), HasSubstr("its type is 5"));
}

class BmpFormats : public Formats {
  protected:
    /// 4 pixels wide, 2 high.
    static Bytes header(uint32_t bits, uint32_t compression, uint32_t colors) {
        const uint32_t offset = 14 + 40 + 4 * colors;
        return "BM" + little(0, 8) + little(offset, 4) + little(40, 4) + little(4, 4) + little(2, 4) +
               little(1, 2) + little(bits, 2) + little(compression, 4) + little(0, 12) + little(colors, 4) +
               little(0, 4);
    }
    const Bytes grays = bytesOf({0, 0, 0, 0, 255, 255, 255, 0});
    const Bytes colors = bytesOf({0, 0, 255, 0, 255, 0, 0, 0});
};

TEST_F(BmpFormats, RunsOfEightAndFourBits) {
    // From the bottom: three of 1 and a 0; a step over two pixels, then 1 and 0 one by one.
    const Bytes eight = bytesOf({3, 1, 1, 0, 0, 0, 0, 2, 2, 0, 1, 1, 1, 0, 0, 1});
    EXPECT_EQ(read("a.bmp", header(8, 1, 2) + grays + eight).pixels, (Floats{0, 0, 1, 0, 1, 1, 1, 0}));
    const Bytes four = bytesOf({4, 0x10, 0, 0, 0, 4, 0x01, 0x10, 0, 1});
    EXPECT_EQ(read("b.bmp", header(4, 2, 2) + colors + four).pixels,
              (Floats{1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0}));
    EXPECT_THAT(errorOf("c.bmp", header(8, 1, 2) + grays + bytesOf({0, 2, 0, 5, 1, 1})),
                HasSubstr("leaves the image"));
    EXPECT_THAT(errorOf("d.bmp", header(8, 1, 2) + grays + bytesOf({4, 7, 0, 1})), HasSubstr("has color 7"));
}

TEST_F(BmpFormats, BitsMasksAndPlainColors) {
    const Bytes bits = bytesOf({0x50, 0, 0, 0, 0xa0, 0, 0, 0});
    EXPECT_EQ(read("a.bmp", header(1, 0, 2) + colors + bits).pixels,
              (Floats{0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1}));
    const Bytes masks = little(0xf800, 4) + little(0x07e0, 4) + little(0x001f, 4);
    Bytes shades;
    for (int i = 0; i < 8; ++i) shades += little(i % 2 ? 0xf800 : 0x07ff, 2);
    const Floats masked = read("b.bmp", header(16, 3, 3) + masks + shades).pixels;
    EXPECT_EQ(Floats(masked.begin(), masked.begin() + 6), (Floats{0, 1, 1, 1, 0, 0}));
    EXPECT_THAT(errorOf("c.bmp", header(8, 4, 2) + grays), HasSubstr("its compression is 4 with 8 bits"));
}

TEST_F(Formats, DeepPixelsAndSubsampledChannelsAreRefused) {
    Bytes deep = corpus("exr_none");
    deep[5] = static_cast<char>(deep[5] | 0x08);
    EXPECT_THAT(errorOf("a.exr", deep), HasSubstr("deep pixels"));
    Bytes subsampled = corpus("exr_none");
    // The first channel: name, type, linear, three zeros, sampling in x.
    const size_t at = subsampled.find("chlist") + 7 + 4 + 2 + 8;
    subsampled[at] = 2;
    EXPECT_NE(errorOf("b.exr", subsampled), "");
}

}  // namespace
}  // namespace metrolux::core
