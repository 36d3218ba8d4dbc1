#include "render/features.h"

#include "base/parallel.h"
#include "base/rng.h"
#include "image/filter.h"
#include "render/pixel_rays.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace metrolux::core {
namespace {

static_assert(kRaysOfPixel == kFeatureSamples);

/// Albedo, normal, inverse distance.
constexpr size_t kValues = 7;
using Values = std::array<float, kValues>;

/// Of what a camera ray meets. Smooth glass and mirrors are passed by one of their lobes, as paths do.
Values follow(const Scene& scene, Ray ray, CounterRng& rng) {
    constexpr int kMostMirrors = 8;
    Values values{};
    Rgb tint(1.0f);
    for (int i = 0; i <= kMostMirrors; ++i) {
        SurfaceInteraction si;
        if (!meetVisibleSurface(scene, ray, si)) return values;
        if (i == 0) {
            const float distance = (si.p - ray.origin).length();
            values[6] = distance > 0 ? 1 / distance : 0;
        }
        const Bsdf* bsdf = si.shape->bsdf.get();
        const Rgb albedo = bsdf ? tint * bsdf->albedo(si) : Rgb(0.0f);
        values[0] = albedo.x, values[1] = albedo.y, values[2] = albedo.z;
        values[3] = si.ns.x, values[4] = si.ns.y, values[5] = si.ns.z;
        if (!bsdf || bsdf->hasSmoothLobe()) return values;
        const Vec3f known = si.toLocal(-ray.direction);
        const float lobe = rng.next1D();
        const auto sample = bsdf->sample(si, known, TransportMode::Radiance, lobe, rng.next2D());
        if (!sample) return values;
        // Light that is refracted is only denser: the tint has no part of that.
        tint *= sample->weight * (sample->eta * sample->eta);
        const Vec3f direction = si.toWorld(sample->direction);
        ray = {offsetRayOrigin(si.p, si.ng, direction), direction};
    }
    return values;
}

struct Sum {
    Values values{};
    float weight = 0;
};

/// Rows of the film that one task renders. It traces the rays of the pixels around them, too, whose samples
/// reach them.
class Band {
  public:
    Band(const Scene& scene, const ReconstructionFilter& filter, int first, int last)
        : scene_(scene),
          filter_(filter),
          window_(scene.camera().window()),
          first_(first),
          last_(last),
          margin_(static_cast<int>(std::ceil(filter.radius() - 0.5f))),
          sums_(static_cast<size_t>(window_.width) * static_cast<size_t>(last - first)) {}

    void render() {
        const int top = std::max(0, window_.y + first_ - margin_),
                  bottom = std::min(window_.fullHeight, window_.y + last_ + margin_);
        const int left = std::max(0, window_.x - margin_),
                  right = std::min(window_.fullWidth, window_.x + window_.width + margin_);
        for (int y = top; y < bottom; ++y)
            for (int x = left; x < right; ++x) renderPixel(x, y);
    }

    void write(DenoisingFeatures& features) const {
        const size_t start = static_cast<size_t>(window_.width) * static_cast<size_t>(first_);
        for (size_t i = 0; i < sums_.size(); ++i) {
            const Sum& sum = sums_[i];
            if (!(sum.weight > 0)) continue;
            const float scale = 1 / sum.weight;
            for (size_t c = 0; c < 3; ++c) {
                features.albedo[3 * (start + i) + c] = scale * sum.values[c];
                features.normal[3 * (start + i) + c] = scale * sum.values[3 + c];
            }
            features.inverseDistance[start + i] = scale * sum.values[6];
        }
    }

  private:
    void renderPixel(int x, int y) {
        CounterRng rng(hashKey(0x66656174, x, y));
        for (int i = 0; i < kFeatureSamples; ++i) {
            const Vec2f raster = rasterOfRay(x, y, i, rng.next2D());
            Values values{};
            if (const auto ray = scene_.camera().sampleRay(rng.next2D(), raster))
                values = follow(scene_, {ray->origin, ray->direction}, rng);
            add(x, y, raster, values);
        }
    }

    void add(int x, int y, const Vec2f& raster, const Values& values) {
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
            for (int i = left; i <= right; ++i) {
                const float weight = rowWeight * columns[static_cast<size_t>(i - left)];
                Sum& sum = line[i - window_.x];
                for (size_t k = 0; k < kValues; ++k) sum.values[k] += weight * values[k];
                sum.weight += weight;
            }
        }
    }

    const Scene& scene_;
    const ReconstructionFilter& filter_;
    const FilmWindow window_;
    int first_, last_, margin_;
    std::vector<Sum> sums_;
};

}  // namespace

DenoisingFeatures renderFeatures(const Scene& scene) {
    constexpr int kRows = 16;
    const FilmWindow& window = scene.camera().window();
    const ReconstructionFilter filter(scene.parts().filterKind, scene.parts().filter);
    const auto count = static_cast<size_t>(window.pixelCount());
    DenoisingFeatures features{std::vector<float>(3 * count), std::vector<float>(3 * count),
                               std::vector<float>(count)};
    parallelFor(static_cast<size_t>((window.height + kRows - 1) / kRows), [&](size_t i) {
        const int first = static_cast<int>(i) * kRows;
        Band band(scene, filter, first, std::min(first + kRows, window.height));
        band.render();
        band.write(features);
    });
    return features;
}

}  // namespace metrolux::core
