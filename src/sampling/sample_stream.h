#pragma once
#include "base/math.h"

namespace metrolux::core {

/// The only source of randomness of transport (Lightmetrica v3, Tungsten): a subpath is a function of a
/// stream.
///
/// Coordinates are laid out in blocks: one for the endpoint, one for each vertex, so that one bounce never
/// shifts the meaning of the next one's coordinates (docs/explain/algorithm.md section 3).
class SampleStream {
  public:
    /// Number of coordinates of the endpoint's block (block 0) and of each vertex's block (1, 2, ...).
    static constexpr int kEndpointBlock = 8;
    static constexpr int kVertexBlock = 4;

    virtual ~SampleStream() = default;
    /// Moves to the first coordinate of a block.
    virtual void seek(int block) = 0;
    virtual float next1D() = 0;  ///< in [0, 1)
    virtual Vec2f next2D() = 0;  ///< in [0, 1)^2
    /// Passes over coordinates that are not needed.
    virtual void skip(int count) = 0;

    static constexpr int blockOffset(int block) {
        return block == 0 ? 0 : kEndpointBlock + (block - 1) * kVertexBlock;
    }
};

}  // namespace metrolux::core
