#include "io/mitsuba/round_shapes.h"

#include "base/frame.h"

#include <algorithm>
#include <cmath>

namespace metrolux::core::mitsuba {
namespace {

constexpr double kTolerance = 1e-3;  // of the shapes themselves

Vec3d column(const Transform& map, int i) { return {map.at(0, i), map.at(1, i), map.at(2, i)}; }

/// The map that has these columns, and `map`'s translation.
Transform withColumns(const Transform& map, const Vec3d& x, const Vec3d& y, const Vec3d& z) {
    return Transform::fromRows({{x.x, y.x, z.x, map.at(0, 3)},
                                {x.y, y.y, z.y, map.at(1, 3)},
                                {x.z, y.z, z.z, map.at(2, 3)},
                                {0, 0, 0, 1}});
}

/// The nearest map that only turns, or turns and mirrors: the orthogonal factor of the polar decomposition by
/// Newton's iteration [Higham 1986, Computing the Polar Decomposition].
Transform orthogonalPart(const Transform& map) {
    Transform q = withColumns(map, column(map, 0), column(map, 1), column(map, 2));
    for (int step = 0; step < 40; ++step) {
        const Transform inverse = q.inverse();
        const auto next = [&](int i) {
            const Vec3d cofactor(inverse.at(i, 0), inverse.at(i, 1), inverse.at(i, 2));
            return (column(q, i) + cofactor) * 0.5;
        };
        q = withColumns(map, next(0), next(1), next(2));
    }
    return q;
}

/// How much the map stretches along the axis, as Mitsuba takes it: 0.6 the length of its image, 3.x the
/// element on the diagonal of the symmetric factor of the polar decomposition.
double stretchAlong(const Element& element, const Transform& map, const Transform& turn, int axis) {
    return element.isLegacy() ? column(map, axis).length()
                              : std::abs(column(turn, axis).dot(column(map, axis)));
}

void warnOfStretch(const Element& element, LoadContext& context, const Transform& map, double radius) {
    context.warn(
        element,
        fmt::format("\"to_world\" has shear or unequal scales ({:.4g}, {:.4g}, {:.4g}): it stays "
                    "round, with the radius {:.6g}, as in Mitsuba",
                    column(map, 0).length(), column(map, 1).length(), column(map, 2).length(), radius));
}

bool isSkewed(const Transform& map, bool alsoAlongZ) {
    const Vec3d x = column(map, 0), y = column(map, 1), z = column(map, 2);
    const double scale = x.length(), height = z.length();
    const double across = std::max({std::abs(x.dot(z)), std::abs(y.dot(z))});
    const bool isOval = std::abs(x.dot(y)) > kTolerance * scale * scale ||
                        std::abs(y.length2() - scale * scale) > kTolerance * scale * scale;
    return isOval || across > kTolerance * scale * height ||
           (alsoAlongZ && std::abs(height * height - scale * scale) > kTolerance * scale * scale);
}

}  // namespace

ShapePtr makeSphereShape(const Element& element, LoadContext& context) {
    Transform map = context.toWorld(element);
    const bool flip = element.boolean("flip_normals", false);
    Vec3d center = element.point("center", Vec3d(0.0));
    const float radius = element.number("radius", 1.0f);
    if (isSkewed(map, true)) {
        const Transform turn = orthogonalPart(map);
        const double stretch = stretchAlong(element, map, turn, 0);
        warnOfStretch(element, context, map, stretch * radius);
        const Vec3d middle = map.exactPoint(center);
        map = withColumns(Transform::translate(middle), column(turn, 0) * stretch, column(turn, 1) * stretch,
                          column(turn, 2) * stretch);
        center = Vec3d(0.0);
    }
    // A map that mirrors turns the normals in 2.x and 3.x, but not in 0.6.
    return makeSphere(map, center, radius, flip != (element.isLegacy() && map.determinant3() < 0));
}

ShapePtr makeCylinderShape(const Element& element, LoadContext& context) {
    const Transform map = context.toWorld(element);
    const bool flip = element.boolean("flip_normals", false);
    const Vec3d p0 = element.point("p0", Vec3d(0, 0, 0)), p1 = element.point("p1", Vec3d(0, 0, 1));
    const float radius = element.number("radius", 1.0f);
    const Vec3d axis = p1 - p0;
    if (!(axis.length() > 0) || !(radius > 0)) return makeCylinder(map, p0, p1, radius, flip);
    const Frame frame = Frame::fromNormal(normalize(Vec3f(axis)));
    const Transform placed = map * withColumns(Transform::translate(p0), Vec3d(frame.s) * double(radius),
                                               Vec3d(frame.t) * double(radius), axis);
    if (!isSkewed(placed, false)) return makeCylinder(map, p0, p1, radius, flip);
    const Transform turn = orthogonalPart(placed);
    const double across = stretchAlong(element, placed, turn, 0),
                 along = stretchAlong(element, placed, turn, 2);
    warnOfStretch(element, context, placed, across);
    const Transform round =
        withColumns(placed, column(turn, 0) * across, column(turn, 1) * across, column(turn, 2) * along);
    return makeCylinder(round, Vec3d(0, 0, 0), Vec3d(0, 0, 1), 1, flip);
}

}  // namespace metrolux::core::mitsuba
