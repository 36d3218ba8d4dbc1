#include "sampling/streams.h"

#include "sampling/sobol.h"

namespace metrolux::core {

SobolStream::SobolStream(uint64_t key, uint32_t index)
    : keyHash_(hashKey(key)), reversedIndex_(sobol::reverseBits(index)) {}

uint64_t SobolStream::hash() const { return extendKey(keyHash_, coordinate_); }

float SobolStream::next1D() {
    const uint64_t h = hash();
    ++coordinate_;
    return sobol::point1D(h, reversedIndex_);
}

Vec2f SobolStream::next2D() {
    const uint64_t h = hash();
    coordinate_ += 2;
    Vec2f point;
    sobol::point2D(h, reversedIndex_, point.x, point.y);
    return point;
}

}  // namespace metrolux::core
