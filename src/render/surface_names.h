#pragma once
#include "scene/scene.h"

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

namespace metrolux::core {

/// What pictures tell apart: shapes by Shape::id and materials by Shape::material. Shapes of one name are one
/// object, and so are all instances of a shape.
class SurfaceNames {
  public:
    explicit SurfaceNames(const Scene& scene);

    /// Each name once, in the order of the scene: shapes, then those of its instances.
    const std::vector<std::string>& objects() const { return objects_; }
    const std::vector<std::string>& materials() const { return materials_; }

    /// Places in those lists.
    struct Place {
        uint32_t object, material;
    };
    Place placeOf(const Shape& shape) const { return places_.at(&shape); }

  private:
    std::vector<std::string> objects_, materials_;
    std::unordered_map<const Shape*, Place> places_;
};

}  // namespace metrolux::core
