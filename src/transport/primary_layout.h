#pragma once
/// Which coordinate of a primary sample means what. A sample is laid out in blocks (SampleStream): block 0
/// belongs to the endpoint, block d to the vertex after d edges. Eye subpaths, light subpaths and next-event
/// estimation have a sample each; where one sample holds all three (PathPair), their blocks take turns.

#include "sampling/sample_stream.h"

namespace metrolux::core::layout {

/// Place in a block of one coordinate, and of two that belong together.
struct One {
    int place;
};
struct Two {
    int place;
};

/// Block 0 of a light subpath.
inline constexpr One kEmitter{0};  ///< choice of the light
inline constexpr Two kEmissionPoint{1};
inline constexpr Two kEmissionDirection{3};
inline constexpr One kEyeSubpath{5};  ///< the one to connect with
inline constexpr Two kSplatLens{6};   ///< point of the lens that its vertices are connected to

/// Block 0 of an eye subpath. A stratified one draws its raster position from the filter of its pixel; one
/// from chains over the image (EyeChains) has the pixel there and that position in kFilter.
inline constexpr Two kRaster{0};
inline constexpr Two kLens{2};
inline constexpr Two kFilter{4};
inline constexpr One kTechnique{4};   ///< of a multiplexed path (PathPair::one)
inline constexpr One kLength{5};      ///< of a multiplexed path
inline constexpr One kWavelength{6};  ///< of a complete path in a scene with dispersion

/// The block of a vertex, in either subpath.
inline constexpr One kLobe{0};
inline constexpr Two kDirection{1};
inline constexpr One kRoulette{3};

/// In scenes with media each edge has a block too, before that of the vertex where it ends.
inline constexpr One kDistance{0};
constexpr int blockOf(int depth, bool media) { return media ? 2 * depth : depth; }
constexpr int distanceBlockOf(int depth) { return 2 * depth - 1; }

/// The block of an eye vertex in the sample of next-event estimation.
inline constexpr One kNeeLight{0};  ///< choice of the light
inline constexpr Two kNeePoint{2};  ///< on it; aligned to a pair

/// The samples that take turns in that of a complete path.
inline constexpr int kEyeStream = 0, kLightStream = 1, kNeeStream = 2, kStreams = 3;

inline void seek(SampleStream& u, int block, int place) {
    u.seek(block);
    if (place > 0) u.skip(place);
}
inline float read(SampleStream& u, One coordinate, int block = 0) {
    seek(u, block, coordinate.place);
    return u.next1D();
}
inline Vec2f read(SampleStream& u, Two coordinates, int block = 0) {
    seek(u, block, coordinates.place);
    return u.next2D();
}
/// Index of a coordinate in the whole sample.
template <class Coordinates>
constexpr int indexOf(Coordinates coordinates, int block) {
    return SampleStream::blockOffset(block) + coordinates.place;
}

}  // namespace metrolux::core::layout
