#pragma once
#include "media/lattice_walk.h"

namespace metrolux::core {

/// Corners of a cell: bit 0 of the number is x, bit 1 is y, bit 2 is z.
inline constexpr int kCorners = 8;

template <class Real>
Real trilinear(const Real (&corner)[kCorners], Real x, Real y, Real z) {
    const auto mix = [](Real a, Real b, Real t) { return a + t * (b - a); };
    const Real z0 = mix(mix(corner[0], corner[1], x), mix(corner[2], corner[3], x), y);
    const Real z1 = mix(mix(corner[4], corner[5], x), mix(corner[6], corner[7], x), y);
    return mix(z0, z1, z);
}

/// Gauss' rule of two points has them that far from the middle of [-1, 1]. It is exact for cubics, which the
/// trilinear interpolant is along a line within a cell.
inline constexpr double kGauss = 0.57735026918962576;

/// One channel of a cell along a ray.
struct GridCell {
    double corner[kCorners];
    Vec3d origin, direction;  ///< of the ray, from corner 0, in cells

    double value(double t) const {
        const Vec3d p = origin + direction * t;
        return trilinear(corner, p.x, p.y, p.z);
    }
    double integral(double begin, double end) const {
        const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
        return half * std::max(value(middle - kGauss * half) + value(middle + kGauss * half), 0.0);
    }
    /// The distance up to which the integral from `begin` on is `target`, or `end` if that comes first:
    /// Newton's method within a bracket.
    double solve(double begin, double end, double target) const {
        const double whole = integral(begin, end);
        if (!(whole > target)) return end;
        double low = begin, high = end, t = begin + (end - begin) * (target / whole);
        for (int i = 0; i < 64; ++i) {
            const double excess = integral(begin, t) - target;
            (excess > 0 ? high : low) = t;
            double next = t - excess / value(t);
            if (!(next > low && next < high)) next = 0.5 * (low + high);
            const double change = std::abs(next - t);
            t = next;
            if (change <= 1e-12 * (end - begin)) break;
        }
        return t;
    }
};

/// A block has that many cells along each axis, at most.
inline constexpr int kBlock = 12;

/// The cells of a block which a ray crosses, in arrays over the cells: what is done with them vectorizes, and
/// their samples come from memory all at once.
struct CellRun {
    static constexpr int kLanes = 8;
    static constexpr int kMost = 3 * kBlock + kLanes;
    int count = 0;
    int padded = 0;              ///< a multiple of kLanes, with cells of no length
    double distance[kMost + 1];  ///< cell i lies between distance[i] and distance[i + 1]
    int x[kMost], y[kMost], z[kMost];

    /// Those of a block, which the ray crosses between two distances. Rounding may add one of no length
    /// beyond the block at each end.
    CellRun(const LatticeRay& ray, double begin, double end) {
        const Stepper alongX(ray, 0, begin), alongY(ray, 1, begin), alongZ(ray, 2, begin);
        int cellX = alongX.cell, cellY = alongY.cell, cellZ = alongZ.cell;
        double nextX = alongX.next, nextY = alongY.next, nextZ = alongZ.next;
        distance[0] = begin;
        // Without branches on the axis, which nobody could predict.
        for (;;) {
            const double exit = std::min(std::min(nextX, nextY), nextZ);
            x[count] = cellX;
            y[count] = cellY;
            z[count] = cellZ;
            ++count;
            distance[count] = std::min(exit, end);
            if (exit >= end || count == 3 * kBlock) break;
            cellX += nextX <= exit ? alongX.step : 0;
            cellY += nextY <= exit ? alongY.step : 0;
            cellZ += nextZ <= exit ? alongZ.step : 0;
            nextX += nextX <= exit ? alongX.delta : 0.0;
            nextY += nextY <= exit ? alongY.delta : 0.0;
            nextZ += nextZ <= exit ? alongZ.delta : 0.0;
        }
        distance[count] = end;
        for (padded = count; padded % kLanes != 0; ++padded) {
            x[padded] = cellX;
            y[padded] = cellY;
            z[padded] = cellZ;
            distance[padded + 1] = end;
        }
    }

  private:
    struct Stepper {
        int cell, step;
        double next, delta;

        Stepper(const LatticeRay& ray, int axis, double begin) {
            const double o = ray.origin[axis], d = ray.direction[axis], i = ray.inverse[axis];
            const double place = std::floor(o + d * begin);
            cell = static_cast<int>(place);
            step = d > 0 ? 1 : -1;
            // A ray along a face may seem to have crossed it before.
            next = d == 0 ? std::numeric_limits<double>::infinity()
                          : std::max((place + (d > 0 ? 1 : 0) - o) * i, begin);
            delta = d == 0 ? 0 : std::abs(i);
        }
    };
};

}  // namespace metrolux::core
