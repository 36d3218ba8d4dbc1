#include "image/cryptomatte.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <bit>
#include <cmath>

namespace metrolux::core {
namespace {

using testing::ElementsAre;

/// Known answers of MurmurHash3_x86_32, of every length modulo four.
TEST(Cryptomatte, NamesAreHashedAsElsewhere) {
    EXPECT_EQ(murmurHash3(""), 0u);
    EXPECT_EQ(murmurHash3("test"), 0xba6bd213u);
    EXPECT_EQ(murmurHash3("hello"), 0x248bfa47u);
    EXPECT_EQ(murmurHash3("hello, world"), 0x149bbb7fu);
    EXPECT_EQ(murmurHash3("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
}

TEST(Cryptomatte, IdsAreNormalNumbers) {
    int corrected = 0;
    for (int i = 0; i < 2000; ++i) {
        const std::string name = "object " + std::to_string(i);
        const uint32_t id = cryptomatteId(name), hash = murmurHash3(name);
        EXPECT_TRUE(std::isnormal(std::bit_cast<float>(id))) << name;
        EXPECT_TRUE(id == hash || (id ^ hash) == 1u << 23) << name;
        corrected += id != hash;
    }
    EXPECT_GT(corrected, 0) << "none of the names needed it";
}

TEST(Cryptomatte, RanksAreByShare) {
    std::vector<std::string> names;
    for (int i = 0; i < 9; ++i) names.push_back(std::to_string(i));
    Cryptomatte mattes("crypto_object", names, 3);
    std::vector<Coverage> some = {{4, 0.25f}, {7, 0.5f}, {2, 0.25f}}, many;
    for (uint32_t i = 0; i < 9; ++i) many.push_back({i, 0.01f * static_cast<float>(i + 1)});
    mattes.set(0, some);
    mattes.set(2, many);
    const Metadata attributes = mattes.attributes();
    const ImageLayer layer = mattes.takeLayer();
    EXPECT_EQ(layer.name, "crypto_object");
    EXPECT_THAT(layer.channels, ElementsAre("00.R", "00.G", "00.B", "00.A", "01.R", "01.G", "01.B", "01.A",
                                            "02.R", "02.G", "02.B", "02.A"));
    const auto at = [&](size_t pixel, size_t rank) {
        const float* pair = &layer.pixels[12 * pixel + 2 * rank];
        return std::pair(std::bit_cast<uint32_t>(pair[0]), pair[1]);
    };
    EXPECT_EQ(at(0, 0), std::pair(cryptomatteId("7"), 0.5f));
    EXPECT_EQ(at(0, 1), std::pair(cryptomatteId("2"), 0.25f));
    EXPECT_EQ(at(0, 2), std::pair(cryptomatteId("4"), 0.25f));
    for (size_t rank = 3; rank < kCryptomatteRanks; ++rank) EXPECT_EQ(at(0, rank), std::pair(0u, 0.0f));
    EXPECT_EQ(at(1, 0), std::pair(0u, 0.0f));
    EXPECT_EQ(at(2, 0).first, cryptomatteId("8"));
    EXPECT_EQ(at(2, 5).first, cryptomatteId("3"));

    // The key is the start of the layer's hash.
    const std::string key = "cryptomatte/" + fmt::format("{:08x}", murmurHash3("crypto_object")).substr(0, 7);
    ASSERT_EQ(attributes.size(), 4u);
    EXPECT_EQ(attributes[0], (std::pair<std::string, MetadataValue>(key + "/name", "crypto_object")));
    EXPECT_EQ(attributes[1].first, key + "/hash");
    EXPECT_EQ(attributes[2].first, key + "/conversion");
    ASSERT_EQ(attributes[3].first, key + "/manifest");
    const auto manifest = nlohmann::json::parse(std::get<std::string>(attributes[3].second));
    EXPECT_EQ(manifest.size(), 9u);
    EXPECT_EQ(manifest["7"], fmt::format("{:08x}", cryptomatteId("7")));
}

}  // namespace
}  // namespace metrolux::core
