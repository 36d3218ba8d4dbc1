#pragma once
#include "base/rng.h"
#include "sampling/sample_stream.h"

namespace metrolux::core {

/// What a random stream is for: part of its key, so that no two purposes share numbers.
enum class StreamPurpose : uint64_t {
    EyeSubpath = 1,
    LightSubpath = 2,
    Chain = 3,
    Seeding = 4,
    Replacement = 5,
    EyeChain = 6
};

/// Independent uniform numbers; coordinate c of the stream depends on (key, c) only.
class IndependentStream final : public SampleStream {
  public:
    explicit IndependentStream(uint64_t key) : rng_(key) {}
    void seek(int block) override { rng_.seek(static_cast<uint64_t>(blockOffset(block))); }
    float next1D() override { return rng_.next1D(); }
    Vec2f next2D() override {
        const float x = rng_.next1D();
        return {x, rng_.next1D()};
    }
    void skip(int count) override { rng_.seek(rng_.counter() + static_cast<uint64_t>(count)); }

  private:
    CounterRng rng_;
};

/// One of several streams that share the coordinates of another: their blocks take turns, so that the blocks
/// of one depth stay together. The streams are independent because no coordinate belongs to two. As they
/// share a position too, seek before reading.
class InterleavedStream final : public SampleStream {
  public:
    /// The index-th of `count` streams.
    InterleavedStream(SampleStream& base, int index, int count) : base_(base), index_(index), count_(count) {}
    void seek(int block) override {
        const int size = block == 0 ? kEndpointBlock : kVertexBlock;
        base_.seek(blockAt(count_ * blockOffset(block) + index_ * size));
    }
    float next1D() override { return base_.next1D(); }
    Vec2f next2D() override { return base_.next2D(); }
    void skip(int count) override { base_.skip(count); }

  private:
    static_assert(kEndpointBlock % kVertexBlock == 0, "else a block could begin within one of the base's");
    static int blockAt(int offset) { return offset == 0 ? 0 : 1 + (offset - kEndpointBlock) / kVertexBlock; }

    SampleStream& base_;
    int index_, count_;
};

/// Owen-scrambled Sobol points: one- and two-dimensional patterns, padded (each block's coordinates are
/// stratified among themselves over the sample index, patterns of different coordinates are shuffled against
/// each other). Hash-based scrambling after Burley 2020, Practical Hash-based Owen Scrambling, with the
/// permutation of Laine & Karras.
class SobolStream final : public SampleStream {
  public:
    /// `key` names the pixel, `index` counts its samples.
    SobolStream(uint64_t key, uint32_t index);
    void seek(int block) override { coordinate_ = static_cast<uint64_t>(blockOffset(block)); }
    float next1D() override;
    Vec2f next2D() override;
    void skip(int count) override { coordinate_ += static_cast<uint64_t>(count); }

  private:
    uint64_t hash() const;    ///< of key and coordinate
    uint64_t keyHash_;        ///< the part of it that does not change
    uint32_t reversedIndex_;  ///< bits in reverse order
    uint64_t coordinate_ = 0;
};

}  // namespace metrolux::core
