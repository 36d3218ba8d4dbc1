#include "render/features.h"

#include "render/filtered_rays.h"

#include <array>

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

    void add(const Values& sample, float w) {
        for (size_t k = 0; k < kValues; ++k) values[k] += w * sample[k];
        weight += w;
    }
};

}  // namespace

DenoisingFeatures renderFeatures(const Scene& scene) {
    const auto count = static_cast<size_t>(scene.camera().window().pixelCount());
    DenoisingFeatures features{std::vector<float>(3 * count), std::vector<float>(3 * count),
                               std::vector<float>(count)};
    renderThroughFilter<Sum>(
        scene, 0x66656174,
        [&](const std::optional<Ray>& ray, CounterRng& rng) {
            return ray ? follow(scene, *ray, rng) : Values{};
        },
        [&](size_t i, const Sum& sum) {
            if (!(sum.weight > 0)) return;
            const float scale = 1 / sum.weight;
            for (size_t c = 0; c < 3; ++c) {
                features.albedo[3 * i + c] = scale * sum.values[c];
                features.normal[3 * i + c] = scale * sum.values[3 + c];
            }
            features.inverseDistance[i] = scale * sum.values[6];
        });
    return features;
}

}  // namespace metrolux::core
