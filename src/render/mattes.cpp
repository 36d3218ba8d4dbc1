#include "render/mattes.h"

#include "render/filtered_rays.h"

namespace metrolux::core {
namespace {

/// Weights of the shapes in a pixel, and of nothing.
struct ShapeWeights {
    struct Entry {
        const Shape* shape;
        float weight;
    };
    std::vector<Entry> entries;
    float sum = 0;

    void add(const Shape* shape, float weight) {
        sum += weight;
        if (!shape) return;
        const auto it =
            std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.shape == shape; });
        if (it != entries.end())
            it->weight += weight;
        else
            entries.push_back({shape, weight});
    }

    /// By names: `place` has that of a shape.
    template <class Place>
    std::vector<Coverage> coverages(const Place& place) const {
        std::vector<Coverage> result;
        for (const Entry& entry : entries) {
            const uint32_t name = place(*entry.shape);
            const auto it =
                std::find_if(result.begin(), result.end(), [&](const Coverage& c) { return c.name == name; });
            if (it != result.end())
                it->share += entry.weight / sum;
            else
                result.push_back({name, entry.weight / sum});
        }
        // Filters with negative lobes go below zero beside edges.
        std::erase_if(result, [](const Coverage& c) { return !(c.share > 0); });
        for (Coverage& c : result) c.share = std::min(c.share, 1.0f);
        return result;
    }
};

}  // namespace

std::vector<Cryptomatte> renderMattes(const Scene& scene, const SurfaceNames& names, bool objects,
                                      bool materials) {
    const auto count = static_cast<size_t>(scene.camera().window().pixelCount());
    Cryptomatte object(kObjectMattes, names.objects(), objects ? count : 0),
        material(kMaterialMattes, names.materials(), materials ? count : 0);
    renderThroughFilter<ShapeWeights>(
        scene, 0x6d61747465,
        [&](const std::optional<Ray>& ray, CounterRng&) -> const Shape* {
            SurfaceInteraction si;
            return ray && meetVisibleSurface(scene, *ray, si) ? si.shape : nullptr;
        },
        [&](size_t pixel, const ShapeWeights& weights) {
            if (!(weights.sum > 0)) return;
            const auto fill = [&](Cryptomatte& mattes, auto place) {
                std::vector<Coverage> coverages =
                    weights.coverages([&](const Shape& shape) { return names.placeOf(shape).*place; });
                mattes.set(pixel, coverages);
            };
            if (objects) fill(object, &SurfaceNames::Place::object);
            if (materials) fill(material, &SurfaceNames::Place::material);
        });
    std::vector<Cryptomatte> result;
    if (objects) result.push_back(std::move(object));
    if (materials) result.push_back(std::move(material));
    return result;
}

}  // namespace metrolux::core
