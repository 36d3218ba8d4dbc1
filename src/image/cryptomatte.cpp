#include "image/cryptomatte.h"

#include "base/printable.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>

namespace metrolux::core {
namespace {

constexpr size_t kChannels = 2 * kCryptomatteRanks;

uint32_t scrambled(uint32_t block) { return std::rotl(block * 0xcc9e2d51u, 15) * 0x1b873593u; }

/// Names are JSON in the attributes, so that the IDs are those of what stands there.
std::vector<std::string> readable(std::vector<std::string> names) {
    for (std::string& name : names) name = validUtf8(name);
    return names;
}

}  // namespace

uint32_t murmurHash3(std::string_view text) {
    const auto byte = [&](size_t i) { return static_cast<uint32_t>(static_cast<unsigned char>(text[i])); };
    uint32_t hash = 0;
    const size_t whole = text.size() / 4 * 4;
    for (size_t i = 0; i < whole; i += 4) {
        hash ^= scrambled(byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
        hash = std::rotl(hash, 13) * 5 + 0xe6546b64u;
    }
    uint32_t rest = 0;
    for (size_t i = text.size(); i > whole; --i) rest = rest << 8 | byte(i - 1);
    if (rest != 0) hash ^= scrambled(rest);
    hash ^= static_cast<uint32_t>(text.size());
    hash = (hash ^ hash >> 16) * 0x85ebca6bu;
    hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
    return hash ^ hash >> 16;
}

uint32_t cryptomatteId(std::string_view name) {
    const uint32_t hash = murmurHash3(name), exponent = hash >> 23 & 0xff;
    return exponent == 0 || exponent == 0xff ? hash ^ 1u << 23 : hash;
}

Cryptomatte::Cryptomatte(std::string name, std::vector<std::string> names, size_t pixels)
    : name_(std::move(name)), names_(readable(std::move(names))) {
    for (const std::string& text : names_) ids_.push_back(cryptomatteId(text));
    layer_.name = name_;
    for (size_t c = 0; c < kChannels; ++c)
        layer_.channels.push_back(fmt::format("{:02}.{}", c / 4, "RGBA"[c % 4]));
    layer_.pixels.resize(kChannels * pixels);
}

void Cryptomatte::set(size_t pixel, std::vector<Coverage>& coverages) {
    // Equal shares are in the order of names, so that files are the same each time.
    std::sort(coverages.begin(), coverages.end(), [](const Coverage& a, const Coverage& b) {
        return a.share != b.share ? a.share > b.share : a.name < b.name;
    });
    float* out = &layer_.pixels[kChannels * pixel];
    for (size_t rank = 0; rank < std::min(kCryptomatteRanks, coverages.size()); ++rank) {
        *out++ = std::bit_cast<float>(ids_[coverages[rank].name]);
        *out++ = coverages[rank].share;
    }
}

Metadata Cryptomatte::attributes() const {
    nlohmann::json manifest = nlohmann::json::object();
    for (size_t i = 0; i < names_.size(); ++i) manifest[names_[i]] = fmt::format("{:08x}", ids_[i]);
    const std::string key =
        fmt::format("cryptomatte/{}/", fmt::format("{:08x}", murmurHash3(name_)).substr(0, 7));
    return {{key + "name", name_},
            {key + "hash", std::string("MurmurHash3_32")},
            {key + "conversion", std::string("uint32_to_float32")},
            {key + "manifest", manifest.dump()}};
}

}  // namespace metrolux::core
