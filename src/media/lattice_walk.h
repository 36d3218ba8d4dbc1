#pragma once
#include "base/transform.h"

#include <limits>

namespace metrolux::core {

/// A ray in the coordinates of a lattice. Distances along it are those in the world, so that the direction
/// has no unit length here.
struct LatticeRay {
    Vec3d origin, direction, inverse;

    LatticeRay(const Vec3d& o, const Vec3d& d) : origin(o), direction(d) {
        for (int axis = 0; axis < 3; ++axis) {
            inverse[axis] = 1 / direction[axis];
            if (!std::isfinite(inverse[axis])) direction[axis] = 0;
        }
    }
    Vec3d at(double t) const { return origin + direction * t; }
};

/// The cubes of side `side` from `first` to `last` which a ray crosses between two distances, in their order
/// (Amanatides and Woo 1987): visit(cube, entry, exit) returns whether to go on. Those at the rim are taken
/// to be open: rounding puts no part of the ray outside. Returns whether visit() let it go on to the end.
template <class Visit>
bool walkLattice(const LatticeRay& ray, double side, const Imath::V3i& first, const Imath::V3i& last,
                 double begin, double end, Visit&& visit) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const Vec3d start = ray.at(begin);
    Imath::V3i cube, step, rim;
    Vec3d next,
        face;  // distance of the face through which the ray leaves along an axis; where it is from cube
    for (int axis = 0; axis < 3; ++axis) {
        const bool isForward = ray.direction[axis] > 0;
        const double place = std::floor(start[axis] / side);
        cube[axis] = static_cast<int>(std::clamp(place, double(first[axis]), double(last[axis])));
        step[axis] = isForward ? 1 : -1;
        rim[axis] = isForward ? last[axis] : first[axis];
        face[axis] = isForward ? 1 : 0;
    }
    const auto leave = [&](int axis) {
        if (cube[axis] == rim[axis] || ray.direction[axis] == 0) return kNever;
        return ((cube[axis] + face[axis]) * side - ray.origin[axis]) * ray.inverse[axis];
    };
    for (int axis = 0; axis < 3; ++axis) next[axis] = leave(axis);
    for (double entry = begin;;) {
        const int axis = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
        const double exit = std::min(next[axis], end);
        if (exit > entry) {
            if (!visit(cube, entry, exit)) return false;
            entry = exit;
        }
        if (!(next[axis] < end)) return true;
        cube[axis] += step[axis];
        next[axis] = leave(axis);
    }
}

}  // namespace metrolux::core
