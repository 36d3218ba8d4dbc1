#pragma once
/// Camera rays without light, seen through the film's reconstruction filter as the image is: what they show
/// has the same edges.

#include "base/parallel.h"
#include "base/rng.h"
#include "image/filter.h"
#include "render/pixel_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace metrolux::core {

/// Rows of the film that one task renders. It traces the rays of the pixels around them, too, whose samples
/// reach them.
template <class Sum>
class FilteredBand {
  public:
    FilteredBand(const Scene& scene, const ReconstructionFilter& filter, int first, int last)
        : scene_(scene),
          filter_(filter),
          window_(scene.camera().window()),
          first_(first),
          last_(last),
          margin_(static_cast<int>(std::ceil(filter.radius() - 0.5f))),
          sums_(static_cast<size_t>(window_.width) * static_cast<size_t>(last - first)) {}

    template <class Trace>
    void render(uint64_t key, const Trace& trace) {
        const int top = std::max(0, window_.y + first_ - margin_),
                  bottom = std::min(window_.fullHeight, window_.y + last_ + margin_);
        const int left = std::max(0, window_.x - margin_),
                  right = std::min(window_.fullWidth, window_.x + window_.width + margin_);
        for (int y = top; y < bottom; ++y)
            for (int x = left; x < right; ++x) {
                CounterRng rng(hashKey(key, x, y));
                for (int i = 0; i < kRaysOfPixel; ++i) {
                    const Vec2f raster = rasterOfRay(x, y, i, rng.next2D());
                    std::optional<Ray> ray;
                    if (const auto sample = scene_.camera().sampleRay(rng.next2D(), raster))
                        ray = Ray{sample->origin, sample->direction};
                    add(x, y, raster, trace(ray, rng));
                }
            }
    }

    template <class Write>
    void write(const Write& write) {
        const size_t start = static_cast<size_t>(window_.width) * static_cast<size_t>(first_);
        for (size_t i = 0; i < sums_.size(); ++i) write(start + i, sums_[i]);
    }

  private:
    template <class Value>
    void add(int x, int y, const Vec2f& raster, const Value& value) {
        std::array<float, 16> columns;  // twice the largest margin
        const int left = std::max(x - margin_, window_.x),
                  right = std::min(x + margin_, window_.x + window_.width - 1);
        for (int i = left; i <= right; ++i)
            columns[static_cast<size_t>(i - left)] = filter_.evaluate(i, window_.fullWidth, raster.x);
        for (int j = std::max(y - margin_, window_.y + first_);
             j <= std::min(y + margin_, window_.y + last_ - 1); ++j) {
            const float rowWeight = filter_.evaluate(j, window_.fullHeight, raster.y);
            if (rowWeight == 0) continue;
            Sum* const line =
                &sums_[static_cast<size_t>(j - window_.y - first_) * static_cast<size_t>(window_.width)];
            for (int i = left; i <= right; ++i)
                line[i - window_.x].add(value, rowWeight * columns[static_cast<size_t>(i - left)]);
        }
    }

    const Scene& scene_;
    const ReconstructionFilter& filter_;
    const FilmWindow window_;
    int first_, last_, margin_;
    std::vector<Sum> sums_;
};

/// kRaysOfPixel rays a pixel. `trace(ray, rng)` has the value of a camera ray, which is nothing where the
/// camera has none; `Sum::add(value, weight)` takes it, weights of some filters being negative; `write(pixel,
/// sum)` is called once for each pixel of the camera's window, by any thread. `key` tells random numbers
/// apart.
template <class Sum, class Trace, class Write>
void renderThroughFilter(const Scene& scene, uint64_t key, const Trace& trace, const Write& write) {
    constexpr int kRows = 16;
    const int height = scene.camera().window().height;
    const ReconstructionFilter filter(scene.parts().filterKind, scene.parts().filter);
    parallelFor(static_cast<size_t>((height + kRows - 1) / kRows), [&](size_t i) {
        const int first = static_cast<int>(i) * kRows;
        FilteredBand<Sum> band(scene, filter, first, std::min(first + kRows, height));
        band.render(key, trace);
        band.write(write);
    });
}

}  // namespace metrolux::core
