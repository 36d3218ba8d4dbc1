#include "render/surface_names.h"

#include <unordered_set>

namespace metrolux::core {

SurfaceNames::SurfaceNames(const Scene& scene) {
    std::unordered_map<std::string, uint32_t> objectPlaces, materialPlaces;
    const auto placeOfName = [](const std::string& name, auto& places, std::vector<std::string>& names) {
        const auto [it, isNew] = places.try_emplace(name, static_cast<uint32_t>(names.size()));
        if (isNew) names.push_back(name);
        return it->second;
    };
    const auto add = [&](const std::vector<ShapePtr>& shapes) {
        for (const ShapePtr& shape : shapes)
            places_.try_emplace(shape.get(), Place{placeOfName(shape->id, objectPlaces, objects_),
                                                   placeOfName(shape->material, materialPlaces, materials_)});
    };
    add(scene.parts().shapes);
    std::unordered_set<const ShapeGroup*> seen;
    for (const Instance& instance : scene.parts().instances)
        if (seen.insert(instance.group.get()).second) add(instance.group->shapes);
}

}  // namespace metrolux::core
