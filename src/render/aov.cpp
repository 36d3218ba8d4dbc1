#include "render/aov.h"

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "render/pixel_rays.h"

#include <algorithm>

namespace metrolux::core {
namespace {

static_assert(kRaysOfPixel == kAovSamples);

/// Means over the camera rays of one pixel.
struct PixelAovs {
    Rgb albedo{0.0f};
    Vec3f normal{0.0f};
    float depth = 0;
    float alpha = 0;
};

PixelAovs samplePixel(const Scene& scene, int x, int y) {
    CounterRng rng(hashKey(0x616f76, x, y));
    PixelAovs sum;
    int hits = 0;
    for (int i = 0; i < kAovSamples; ++i) {
        const Vec2f raster = rasterOfRay(x, y, i, rng.next2D());
        const auto ray = scene.camera().sampleRay(rng.next2D(), raster);
        SurfaceInteraction si;
        if (!ray || !meetVisibleSurface(scene, {ray->origin, ray->direction}, si)) continue;
        ++hits;
        if (si.shape->bsdf) sum.albedo += si.shape->bsdf->albedo(si);
        sum.normal += si.ns;
        sum.depth += (si.p - ray->origin).length();
    }
    sum.albedo *= 1.0f / kAovSamples;
    sum.normal *= 1.0f / kAovSamples;
    sum.alpha = static_cast<float>(hits) / kAovSamples;
    if (hits > 0) sum.depth /= static_cast<float>(hits);
    return sum;
}

}  // namespace

Aov aovFromName(const std::string& name) {
    if (name == "albedo") return Aov::Albedo;
    if (name == "normal") return Aov::Normal;
    if (name == "depth") return Aov::Depth;
    if (name == "variance") return Aov::Variance;
    if (name == kDenoisedLayer) return Aov::Denoised;
    if (name == kAlphaLayer) return Aov::Alpha;
    throw Error("unknown AOV '{}', expected albedo, normal, depth, variance, alpha or denoised", name);
}

std::vector<ImageLayer> renderAovs(const Scene& scene, const std::vector<Aov>& wanted) {
    const auto isWanted = [&](Aov aov) {
        return std::find(wanted.begin(), wanted.end(), aov) != wanted.end();
    };
    const bool albedo = isWanted(Aov::Albedo), normal = isWanted(Aov::Normal), depth = isWanted(Aov::Depth),
               alpha = isWanted(Aov::Alpha);
    if (!albedo && !normal && !depth && !alpha) return {};

    const FilmWindow& window = scene.camera().window();
    const auto count = static_cast<size_t>(window.pixelCount()), width = static_cast<size_t>(window.width);
    ImageLayer albedoLayer{"albedo", {"R", "G", "B"}, std::vector<float>(3 * count)};
    ImageLayer normalLayer{"normal", {"X", "Y", "Z"}, std::vector<float>(3 * count)};
    ImageLayer depthLayer{"depth", {"Z"}, std::vector<float>(count)};
    ImageLayer alphaLayer{kAlphaLayer, {"A"}, std::vector<float>(count)};
    parallelFor(static_cast<size_t>(window.height), [&](size_t y) {
        for (size_t x = 0; x < width; ++x) {
            const PixelAovs pixel =
                samplePixel(scene, window.x + static_cast<int>(x), window.y + static_cast<int>(y));
            const size_t i = y * width + x;
            for (size_t c = 0; c < 3; ++c) {
                albedoLayer.pixels[3 * i + c] = pixel.albedo[static_cast<int>(c)];
                normalLayer.pixels[3 * i + c] = pixel.normal[static_cast<int>(c)];
            }
            depthLayer.pixels[i] = pixel.depth;
            alphaLayer.pixels[i] = pixel.alpha;
        }
    });
    std::vector<ImageLayer> layers;
    if (albedo) layers.push_back(std::move(albedoLayer));
    if (normal) layers.push_back(std::move(normalLayer));
    if (depth) layers.push_back(std::move(depthLayer));
    if (alpha) layers.push_back(std::move(alphaLayer));
    return layers;
}

ImageLayer varianceLayer(const Film& film) { return {"variance", {"Y"}, film.variance()}; }

}  // namespace metrolux::core
