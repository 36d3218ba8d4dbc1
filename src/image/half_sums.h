#pragma once
#include "image/film.h"

#include <span>
#include <utility>
#include <vector>

namespace metrolux::core {

/// Whether a pass belongs to the first of two halves of a rendering. The halves alternate in blocks that grow
/// with the number of passes: A, B, BA, ABBA, AABBBBAA ... A half has between a third and two thirds of any
/// number of passes from two on, and half of them at powers of two. Neighboring passes of a chain resemble
/// each other; only at the borders of blocks does one half know of the other.
bool isOfFirstHalf(uint32_t pass);

/// The sums of one pixel where runs of passes of the first half have begun and ended: their difference is the
/// half. Both only grow, so that those of processes add up in any order to the same bits.
struct PixelHalf {
    ExactSum<63> begun[3], ended[3];
    PixelHalf& operator+=(const PixelHalf& other) {
        for (int c = 0; c < 3; ++c) begun[c] += other.begun[c], ended[c] += other.ended[c];
        return *this;
    }
    template <class Archive>
    void serialize(Archive& archive) {
        archive(begun[0], begun[1], begun[2], ended[0], ended[1], ended[2]);
    }
};

/// Keeps apart what the two halves of the passes have added to a film: two images of independent noise, from
/// which a filter learns how far to trust each. The film itself is only read.
class HalfSums {
  public:
    explicit HalfSums(size_t pixels) : pixels_(pixels) {}

    /// Before a pass: it belongs to the first half, or to the second. `film` has no pass under way.
    void enter(bool first, const Film& film);
    /// Before the state is used: the run of passes in progress ends here, and enter() begins another.
    void close(const Film& film);
    bool isOpen() const { return open_; }

    uint32_t firstPasses() const { return passes_; }
    std::span<const PixelHalf> pixels() const { return pixels_; }

    /// Adds the closed halves of another film, of as many pixels. Throws Error for another number.
    void add(const HalfSums& other) { add(other.pixels_, other.passes_); }
    void add(std::span<const PixelHalf> pixels, uint32_t passes);

    /// Means over the passes of each half, as Film::image(); all zero for a half that has none. Closed.
    std::pair<std::vector<float>, std::vector<float>> means(const Film& film) const;

    /// Closed.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(passes_);
        serializeElements(archive, pixels_, "pixels");
    }

  private:
    std::vector<PixelHalf> pixels_;
    uint32_t passes_ = 0;
    bool open_ = false;  ///< the pass before was of the first half
};

}  // namespace metrolux::core
