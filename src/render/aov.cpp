#include "render/aov.h"

#include "base/error.h"
#include "base/parallel.h"
#include "base/printable.h"
#include "base/rng.h"
#include "render/mattes.h"
#include "render/pixel_rays.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

namespace metrolux::core {
namespace {

static_assert(kRaysOfPixel == kAovSamples);

/// Where the values of a layer come from.
enum class Source {
    Means,    ///< over the rays of a pixel
    Middle,   ///< of its middle
    Nowhere,  ///< zero
    Mattes,
    Film
};
struct Description {
    Aov aov;
    const char* name;
    const char* channels;  ///< a letter each
    Source source;
    bool isShown = false;
};
constexpr Description kDescriptions[] = {{Aov::Albedo, "albedo", "RGB", Source::Means, true},
                                         {Aov::Normal, "normal", "XYZ", Source::Means, true},
                                         {Aov::Depth, "depth", "Z", Source::Means, true},
                                         {Aov::Alpha, kAlphaLayer, "A", Source::Means, true},
                                         {Aov::Position, "position", "XYZ", Source::Middle},
                                         {Aov::Uv, "uv", "UV", Source::Middle},
                                         {Aov::Object, "object", "X", Source::Middle},
                                         {Aov::Material, "material", "X", Source::Middle},
                                         {Aov::Motion, "motion", "XY", Source::Nowhere},
                                         {Aov::ObjectMattes, kObjectMattes, "", Source::Mattes},
                                         {Aov::MaterialMattes, kMaterialMattes, "", Source::Mattes},
                                         {Aov::Variance, "variance", "Y", Source::Film},
                                         {Aov::Denoised, kDenoisedLayer, "RGB", Source::Film, true}};

/// Means over the camera rays of one pixel.
struct PixelMeans {
    Rgb albedo{0.0f};
    Vec3f normal{0.0f};
    float depth = 0;
    float alpha = 0;
};

PixelMeans samplePixel(const Scene& scene, int x, int y) {
    CounterRng rng(hashKey(0x616f76, x, y));
    PixelMeans sum;
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

/// What the ray through the middle of a pixel and of the lens meets.
std::optional<SurfaceInteraction> middleOf(const Scene& scene, int x, int y) {
    const Vec2f raster{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
    const auto ray = scene.camera().sampleRay(Vec2f(0.5f), raster);
    SurfaceInteraction si;
    if (!ray || !meetVisibleSurface(scene, {ray->origin, ray->direction}, si)) return std::nullopt;
    return si;
}

void write(Aov aov, const PixelMeans& means, float* out) {
    if (aov == Aov::Albedo) std::copy_n(&means.albedo.x, 3, out);
    if (aov == Aov::Normal) std::copy_n(&means.normal.x, 3, out);
    if (aov == Aov::Depth) *out = means.depth;
    if (aov == Aov::Alpha) *out = means.alpha;
}

void write(Aov aov, const SurfaceInteraction& si, const SurfaceNames& names, const Vec3d& origin,
           float* out) {
    if (aov == Aov::Position)
        for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(origin[c] + double(si.p[c]));
    if (aov == Aov::Uv) out[0] = si.uv.x, out[1] = si.uv.y;
    if (aov == Aov::Object) *out = static_cast<float>(names.placeOf(*si.shape).object + 1);
    if (aov == Aov::Material) *out = static_cast<float>(names.placeOf(*si.shape).material + 1);
}

/// A list of names as an attribute.
std::string listed(const std::vector<std::string>& names) {
    nlohmann::json list = nlohmann::json::array();
    for (const std::string& name : names) list.push_back(validUtf8(name));
    return list.dump();
}

}  // namespace

Aov aovFromName(const std::string& name) {
    for (const Description& d : kDescriptions)
        if (name == d.name) return d.aov;
    throw Error("unknown AOV '{}', expected one of {}", name, aovNames());
}

std::string aovNames() {
    std::string names;
    for (const Description& d : kDescriptions) names += (names.empty() ? "" : ", ") + std::string(d.name);
    return names;
}

bool isShown(Aov aov) {
    return std::any_of(std::begin(kDescriptions), std::end(kDescriptions),
                       [&](const Description& d) { return d.aov == aov && d.isShown; });
}

CameraLayers renderAovs(const Scene& scene, const std::vector<Aov>& wanted) {
    const FilmWindow& window = scene.camera().window();
    const auto count = static_cast<size_t>(window.pixelCount()), width = static_cast<size_t>(window.width);
    CameraLayers result;
    std::vector<const Description*> filled;
    std::optional<SurfaceNames> names;
    bool means = false, middle = false, objects = false, materials = false;
    for (const Description& d : kDescriptions) {
        if (d.source == Source::Film || std::find(wanted.begin(), wanted.end(), d.aov) == wanted.end())
            continue;
        means |= d.source == Source::Means;
        middle |= d.source == Source::Middle;
        objects |= d.aov == Aov::ObjectMattes;
        materials |= d.aov == Aov::MaterialMattes;
        if (!names && (d.source == Source::Middle || d.source == Source::Mattes)) names.emplace(scene);
        if (d.aov == Aov::Object)
            result.attributes.emplace_back("metrolux:objects", listed(names->objects()));
        if (d.aov == Aov::Material)
            result.attributes.emplace_back("metrolux:materials", listed(names->materials()));
        if (d.source == Source::Mattes) continue;
        ImageLayer layer{d.name, {}, {}};
        for (const char* c = d.channels; *c; ++c) layer.channels.emplace_back(1, *c);
        layer.pixels.resize(layer.channels.size() * count);
        result.layers.push_back(std::move(layer));
        filled.push_back(&d);
    }
    parallelFor(means || middle ? static_cast<size_t>(window.height) : 0, [&](size_t row) {
        const int y = window.y + static_cast<int>(row);
        for (size_t column = 0; column < width; ++column) {
            const int x = window.x + static_cast<int>(column);
            PixelMeans pixel;
            std::optional<SurfaceInteraction> si;
            if (means) pixel = samplePixel(scene, x, y);
            if (middle) si = middleOf(scene, x, y);
            for (size_t k = 0; k < filled.size(); ++k) {
                ImageLayer& layer = result.layers[k];
                float* const out = &layer.pixels[(row * width + column) * layer.channels.size()];
                if (filled[k]->source == Source::Means) write(filled[k]->aov, pixel, out);
                if (filled[k]->source == Source::Middle && si)
                    write(filled[k]->aov, *si, *names, scene.parts().origin, out);
            }
        }
    });
    if (objects || materials)
        for (Cryptomatte& mattes : renderMattes(scene, *names, objects, materials)) {
            for (auto& attribute : mattes.attributes()) result.attributes.push_back(std::move(attribute));
            result.layers.push_back(mattes.takeLayer());
        }
    return result;
}

ImageLayer varianceLayer(const Film& film) { return {"variance", {"Y"}, film.variance()}; }

}  // namespace metrolux::core
