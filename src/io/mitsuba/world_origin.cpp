#include "io/mitsuba/world_origin.h"

#include <algorithm>
#include <set>

namespace metrolux::core::mitsuba {
namespace {

/// Distance from the origin in units of the extent from which on a scene is moved. At this distance rays
/// leave surfaces by 2e-4 of the extent.
constexpr double kFar = 64;
/// Where positions lose what single precision cannot hold, so that meshes of unknown size do not matter.
constexpr double kVeryFar = 65536;
constexpr double kLargestCoordinate = 1.8e18;

/// The lower median.
double median(std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Medians, as a ground plane or a sky may be of any size.
struct Region {
    Vec3d center{0.0};
    double extent = 0;  ///< from the center to the far end of a box

    explicit Region(const std::vector<Box>& boxes) {
        std::vector<double> values(boxes.size());
        if (boxes.empty()) return;
        for (int axis = 0; axis < 3; ++axis) {
            std::transform(boxes.begin(), boxes.end(), values.begin(),
                           [&](const Box& b) { return 0.5 * (b.lower[axis] + b.upper[axis]); });
            center[axis] = median(values);
        }
        std::transform(boxes.begin(), boxes.end(), values.begin(), [&](const Box& b) {
            Vec3d far;
            for (int axis = 0; axis < 3; ++axis)
                far[axis] =
                    std::max(std::abs(b.lower[axis] - center[axis]), std::abs(b.upper[axis] - center[axis]));
            return far.length();
        });
        extent = median(values);
    }

    /// Rounded, so that the coordinates of the file differ from it by few digits.
    Vec3d origin() const {
        const double step = std::exp2(std::floor(std::log2(std::max(extent, 1e-30))));
        return {std::round(center.x / step) * step, std::round(center.y / step) * step,
                std::round(center.z / step) * step};
    }
    bool isBeyond(double distance) const { return extent > 0 && center.length() > distance * extent; }
};

template <class T>
T valueOf(const Element& element, const std::string& name, const T& fallback) {
    for (const auto& [key, property] : element.named)
        if (const T* value = key == name ? std::get_if<T>(&property.value) : nullptr) return *value;
    return fallback;
}

void guessBoxes(const Element& element, std::vector<Box>& boxes) {
    const auto visit = [&](const Property& property) {
        const ElementPtr* child = std::get_if<ElementPtr>(&property.value);
        if (!child || !*child || (*child)->tag != "shape" || (*child)->type == "shapegroup") return;
        const Element& shape = **child;
        if (shape.type == "merge") {
            guessBoxes(shape, boxes);
            return;
        }
        const Transform map = valueOf(shape, "to_world", Transform());
        const Vec3d center =
            map.exactPoint(valueOf(shape, shape.type == "cylinder" ? "p0" : "center", Vec3d(0.0)));
        Vec3d half;
        for (int i = 0; i < 3; ++i)
            half[i] = std::abs(map.at(i, 0)) + std::abs(map.at(i, 1)) + std::abs(map.at(i, 2));
        half *= valueOf(shape, "radius", 1.0);
        boxes.push_back({center - half, center + half});
    };
    for (const auto& [name, property] : element.named) visit(property);
    for (const Property& property : element.children) visit(property);
}

void forgetReads(const Element& element, std::set<const Element*>& visited) {
    if (!visited.insert(&element).second) return;
    const auto visit = [&](const Property& property) {
        property.used = false;
        if (const ElementPtr* child = std::get_if<ElementPtr>(&property.value); child && *child)
            forgetReads(**child, visited);
    };
    for (const auto& [name, property] : element.named) visit(property);
    for (const Property& property : element.children) visit(property);
}

}  // namespace

Box boxOf(const Shape& shape) {
    Vec3f lower, upper;
    shape.bounds(lower, upper);
    return {Vec3d(lower), Vec3d(upper)};
}

Box boxUnder(const Transform& map, const Box& box) {
    Box result{Vec3d(std::numeric_limits<double>::infinity()),
               Vec3d(-std::numeric_limits<double>::infinity())};
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d p =
            map.exactPoint({corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
                            corner & 4 ? box.upper.z : box.lower.z});
        for (int axis = 0; axis < 3; ++axis) {
            result.lower[axis] = std::min(result.lower[axis], p[axis]);
            result.upper[axis] = std::max(result.upper[axis], p[axis]);
        }
    }
    return result;
}

std::vector<Box> boxesOf(const std::vector<ShapePtr>& shapes, const std::vector<Instance>& instances) {
    std::vector<Box> result;
    for (const ShapePtr& shape : shapes) result.push_back(boxOf(*shape));
    std::map<const ShapeGroup*, std::vector<Box>> groups;
    for (const Instance& instance : instances) {
        const auto [entry, isNew] = groups.try_emplace(instance.group.get());
        if (isNew) entry->second = boxesOf(instance.group->shapes, {});
        for (const Box& box : entry->second) result.push_back(boxUnder(instance.toWorld, box));
    }
    return result;
}

Vec3d originFor(const std::vector<Box>& boxes) {
    const Region region(boxes);
    return region.isBeyond(kFar) ? region.origin() : Vec3d(0.0);
}

Vec3d originFor(std::vector<Box> boxes, const Vec3d& origin) {
    const Region around(boxes);
    for (Box& box : boxes) {
        box.lower += origin;
        box.upper += origin;
    }
    const Vec3d result = originFor(boxes);
    const bool isNeeded = result != Vec3d(0.0), serves = !around.isBeyond(kFar);
    return isNeeded && serves ? origin : result;
}

Vec3d guessedOrigin(const Element& scene) {
    std::vector<Box> boxes;
    guessBoxes(scene, boxes);
    const Region region(boxes);
    const bool isVeryFar = region.isBeyond(kVeryFar) && region.center.length() > kVeryFar;
    return isVeryFar ? region.origin() : Vec3d(0.0);
}

Transform movedBy(const Vec3d& offset, const Transform& map) {
    if (offset == Vec3d(0.0)) return map;
    const double rows[4][4] = {{1, 0, 0, offset.x}, {0, 1, 0, offset.y}, {0, 0, 1, offset.z}, {0, 0, 0, 1}};
    return Transform::fromRows(rows) * map;
}

void requirePlaceable(const Element& element, const Vec3d& lower, const Vec3d& upper) {
    for (int axis = 0; axis < 3; ++axis)
        if (!(lower[axis] >= -kLargestCoordinate && upper[axis] <= kLargestCoordinate))
            throw element.error(fmt::format(
                "reaches from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g}), expected coordinates "
                "within {:.2g}",
                lower.x, lower.y, lower.z, upper.x, upper.y, upper.z, kLargestCoordinate));
}

void forgetReads(const Element& element) {
    std::set<const Element*> visited;
    forgetReads(element, visited);
}

}  // namespace metrolux::core::mitsuba
