#pragma once
#include "base/math.h"

#include <cstddef>
#include <span>
#include <vector>

namespace metrolux::core {

/// Points that lie at equal distances in memory: an array of them, or a member of the elements of an array.
class PointSpan {
  public:
    PointSpan(const std::vector<Vec3f>& points)  // NOLINT(google-explicit-constructor): it is a view of them
        : first_(reinterpret_cast<const std::byte*>(points.data())),
          stride_(sizeof(Vec3f)),
          size_(points.size()) {}
    /// `pointOf(element)`: the member, by reference.
    template <class Element, class PointOf>
    PointSpan(std::span<const Element> elements, PointOf&& pointOf)
        : first_(elements.empty() ? nullptr : reinterpret_cast<const std::byte*>(&pointOf(elements[0]))),
          stride_(sizeof(Element)),
          size_(elements.size()) {}

    size_t size() const { return size_; }
    const Vec3f& operator[](size_t i) const { return *reinterpret_cast<const Vec3f*>(first_ + i * stride_); }

  private:
    const std::byte* first_;
    size_t stride_, size_;
};

}  // namespace metrolux::core
