#pragma once
/// Cryptomatte: mattes of named things as layers of an EXR [Friedman & Jones 2015, "Fully Automatic ID Mattes
/// with Support for Motion Blur and Transparency"; Cryptomatte specification 1.2.0].

#include "image/image_io.h"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace metrolux::core {

/// MurmurHash3_x86_32 with seed 0.
uint32_t murmurHash3(std::string_view text);

/// Bits of the float that stands for a name: its hash, as a normal number. 0 stands for nothing.
uint32_t cryptomatteId(std::string_view name);

/// Share of a pixel that a name has.
struct Coverage {
    uint32_t name;  ///< index
    float share;    ///< more than 0; those of a pixel need not sum to 1
};

/// Names that a layer keeps for each pixel, those with the largest shares.
inline constexpr size_t kCryptomatteRanks = 6;

/// Pixels of a layer, which are filled one by one, by any threads.
class Cryptomatte {
  public:
    /// `name`: of the layer, "crypto_object".
    Cryptomatte(std::string name, std::vector<std::string> names, size_t pixels);

    /// Coverages of the pixel, each name once, in any order.
    void set(size_t pixel, std::vector<Coverage>& coverages);

    /// kCryptomatteRanks times ID and share: channels "00.R", "00.G", "00.B", "00.A", "01.R" ...
    ImageLayer takeLayer() { return std::move(layer_); }
    /// The attributes by which readers find the layer, with the names and their IDs.
    Metadata attributes() const;

  private:
    std::string name_;
    std::vector<std::string> names_;
    std::vector<uint32_t> ids_;  ///< of names_
    ImageLayer layer_;
};

}  // namespace metrolux::core
