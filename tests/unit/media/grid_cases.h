#pragma once
/// Grids for tests, and what they are by definition: slow, in double precision, and without any code of the
/// module.

#include "base/rng.h"
#include "media/grid_volume.h"

#include <algorithm>
#include <string>
#include <vector>

namespace metrolux::core::test {

struct GridCase {
    std::string name;
    GridSamples samples;
    GridSettings settings;

    VolumePtr volume() const { return makeGridVolume(samples, settings); }

    double sample(int x, int y, int z, int channel) const {
        const Imath::V3i n = samples.resolution;
        const auto wrap = [&](int i, int count) {
            if (settings.wrap == GridWrap::Clamp) return std::clamp(i, 0, count - 1);
            const int period = settings.wrap == GridWrap::Mirror ? 2 * count : count;
            const int inside = ((i % period) + period) % period;
            return inside < count ? inside : period - 1 - inside;
        };
        const auto at =
            (static_cast<size_t>(wrap(z, n.z)) * size_t(n.y) + size_t(wrap(y, n.y))) * size_t(n.x) +
            size_t(wrap(x, n.x));
        return double(
            samples.values[at * size_t(samples.channels) + size_t(samples.channels == 1 ? 0 : channel)]);
    }
    /// In units of samples, of which sample i is at i.
    Vec3d place(const Vec3d& p) const {
        Vec3d local = settings.toWorld.inverse().exactPoint(p);
        for (int a = 0; a < 3; ++a) {
            const int n = samples.resolution[a];
            local[a] = settings.placement == GridPlacement::Nodes ? local[a] * (n - 1) : local[a] * n - 0.5;
        }
        return local;
    }
    double value(const Vec3d& p, int channel) const {
        const Vec3d at = place(p);
        if (settings.placement == GridPlacement::Nodes)
            for (int a = 0; a < 3; ++a)
                if (at[a] < 0 || at[a] > samples.resolution[a] - 1) return 0;
        if (settings.filter == GridFilter::Nearest)
            return sample(int(std::floor(at.x + 0.5)), int(std::floor(at.y + 0.5)),
                          int(std::floor(at.z + 0.5)), channel);
        const int x = int(std::floor(at.x)), y = int(std::floor(at.y)), z = int(std::floor(at.z));
        double sum = 0;
        for (int k = 0; k < 8; ++k) {
            const int i = k & 1, j = k >> 1 & 1, l = k >> 2;
            const double weight =
                std::abs(1 - i - (at.x - x)) * std::abs(1 - j - (at.y - y)) * std::abs(1 - l - (at.z - z));
            if (weight > 0) sum += weight * sample(x + i, y + j, z + l, channel);
        }
        return sum;
    }
    bool isWithinBounds(const Vec3d& p) const {
        Vec3d low(1e300), high(-1e300);
        for (int k = 0; k < 8; ++k) {
            const Vec3d corner = settings.toWorld.exactPoint(Vec3d(k & 1, k >> 1 & 1, k >> 2));
            for (int a = 0; a < 3; ++a) {
                low[a] = std::min(low[a], corner[a]);
                high[a] = std::max(high[a], corner[a]);
            }
        }
        for (int a = 0; a < 3; ++a)
            if (p[a] < low[a] || p[a] > high[a]) return false;
        return true;
    }
    /// Integral along a segment. Between all faces of the lattice, which are the places where the interpolant
    /// is not a polynomial, by the midpoint rule on many pieces; bounds are cut by the middle of each.
    double integral(const Vec3d& origin, const Vec3d& direction, double length, int channel) const {
        const Vec3d from = place(origin), to = place(origin + direction * length);
        std::vector<double> cuts{0, length};
        for (int a = 0; a < 3; ++a) {
            const double low = std::min(from[a], to[a]), high = std::max(from[a], to[a]);
            if (high - low < 1e-12) continue;
            for (double face = std::ceil(2 * low) / 2; face <= high; face += 0.5)
                cuts.push_back((face - from[a]) / (to[a] - from[a]) * length);
        }
        for (int a = 0; a < 3; ++a)  // the bounds of the world
            for (int k = 0; k < 8; ++k) {
                const Vec3d corner = settings.toWorld.exactPoint(Vec3d(k & 1, k >> 1 & 1, k >> 2));
                if (direction[a] != 0) cuts.push_back((corner[a] - origin[a]) / direction[a]);
            }
        std::sort(cuts.begin(), cuts.end());
        constexpr int kPieces = 40;
        double sum = 0;
        for (size_t i = 0; i + 1 < cuts.size(); ++i) {
            const double a = std::clamp(cuts[i], 0.0, length), b = std::clamp(cuts[i + 1], 0.0, length);
            if (b - a < 1e-14 * length || !isWithinBounds(origin + direction * (0.5 * (a + b)))) continue;
            for (int k = 0; k < kPieces; ++k)
                sum += value(origin + direction * (a + (b - a) * (k + 0.5) / kPieces), channel) * (b - a) /
                       kPieces;
        }
        return sum;
    }
};

/// Samples in [0, 1]; `empty`: the part of them that is zero, in lumps.
inline GridSamples randomSamples(const Imath::V3i& resolution, int channels, uint64_t seed,
                                 double empty = 0) {
    GridSamples samples;
    samples.resolution = resolution;
    samples.channels = channels;
    CounterRng rng(hashKey(seed, 5));
    for (int z = 0; z < resolution.z; ++z)
        for (int y = 0; y < resolution.y; ++y)
            for (int x = 0; x < resolution.x; ++x)
                for (int c = 0; c < channels; ++c) {
                    const bool isEmpty = toUnitFloat(hashKey(seed, x / 9, y / 9, z / 9)) < empty;
                    samples.values.push_back(rng.next1D() * (isEmpty ? 0.0f : 1.0f));
                }
    return samples;
}

inline std::vector<std::pair<std::string, Transform>> gridTransforms() {
    const Transform center = Transform::translate({-0.5, -0.5, -0.5});
    const double sheared[4][4] = {{1, 0.7, 0, 0.2}, {0, 1.5, -0.4, 0}, {0.1, 0, 0.8, -1}, {0, 0, 0, 1}};
    return {{"identity", {}},
            {"box", Transform::translate({3, -2, 0.5}) * Transform::scale({2, 0.5f, 1.25f})},
            {"rotated", Transform::rotate({1, 2, 3}, 40) * center},
            {"quarter turn", Transform::rotate({0, 0, 1}, 90) * center},
            {"mirrored", Transform::scale({-1, 1, 2}) * Transform::rotate({0, 1, 0}, 20) * center},
            {"sheared", Transform::fromRows(sheared)}};
}

/// All filters, wraps and placements, resolutions of few and of many blocks, one and three channels.
inline std::vector<GridCase> gridCases() {
    std::vector<GridCase> cases;
    struct Shape {
        Imath::V3i resolution;
        int channels;
        double empty;
    };
    uint64_t seed = 0;
    for (const Shape& shape : {Shape{{5, 3, 4}, 1, 0}, Shape{{1, 1, 1}, 1, 0}, Shape{{2, 2, 2}, 3, 0},
                               Shape{{33, 1, 14}, 1, 0}, Shape{{40, 31, 26}, 3, 0.6}})
        for (const auto& [transformName, transform] : gridTransforms())
            for (const bool isNodes : {false, true})
                for (const GridFilter filter : {GridFilter::Trilinear, GridFilter::Nearest})
                    for (const GridWrap wrap : {GridWrap::Clamp, GridWrap::Repeat, GridWrap::Mirror}) {
                        const Imath::V3i n = shape.resolution;
                        if (isNodes && (filter == GridFilter::Nearest || wrap != GridWrap::Clamp ||
                                        std::min({n.x, n.y, n.z}) < 2))
                            continue;
                        GridCase one;
                        one.samples = randomSamples(n, shape.channels, ++seed, shape.empty);
                        one.settings = {filter, wrap, isNodes ? GridPlacement::Nodes : GridPlacement::Cells,
                                        transform};
                        one.name = fmt::format("{}x{}x{} of {} channels, {}, {}, wrap {}{}", n.x, n.y, n.z,
                                               shape.channels, transformName,
                                               filter == GridFilter::Nearest ? "nearest" : "trilinear",
                                               int(wrap), isNodes ? ", nodes" : "");
                        cases.push_back(std::move(one));
                    }
    return cases;
}

struct Segment {
    Vec3f origin, direction;
    float length;
};

/// Segments of every kind around a grid: from outside and inside, along axes and faces of the world and of
/// the lattice, through its nodes.
inline std::vector<Segment> segmentsFor(const GridCase& grid, uint64_t seed) {
    CounterRng rng(hashKey(seed, 6));
    const auto between = [&](double a, double b) { return a + (b - a) * rng.nextDouble(); };
    const auto world = [&](const Vec3d& local) { return Vec3f(grid.settings.toWorld.exactPoint(local)); };
    const auto randomLocal = [&](double low, double high) {
        return Vec3d(between(low, high), between(low, high), between(low, high));
    };
    const auto node = [&] {
        Vec3d p;
        for (int a = 0; a < 3; ++a) {
            const int n = grid.samples.resolution[a];
            p[a] = (std::floor(between(0, n)) + 0.5) / n;
        }
        return p;
    };
    std::vector<Segment> segments;
    const auto add = [&](const Vec3f& from, const Vec3f& to, float factor) {
        if (lengthSquared(to - from) > 1e-6f)
            segments.push_back({from, normalize(to - from), (to - from).length() * factor});
    };
    for (int i = 0; i < 6; ++i) {
        add(world(randomLocal(-1, 2)), world(randomLocal(0, 1)), 3);
        add(world(randomLocal(0, 1)), world(randomLocal(0, 1)), 1);
        add(world(node()), world(node()), 1);  // through corners of cells
        add(world(node()), world(randomLocal(-1, 2)), 2);
        // Along an axis of the lattice, between and on its faces.
        for (const bool onNode : {false, true}) {
            const Vec3d local = onNode ? node() : randomLocal(0, 1);
            Vec3d a = local, b = local;
            a[i % 3] = i < 3 ? -0.5 : 1.5;
            b[i % 3] = i < 3 ? 1.5 : -0.5;
            add(world(a), world(b), 1);
        }
        // Along an axis of the world, either way.
        Vec3f direction(0.0f);
        direction[i % 3] = i < 3 ? 1.0f : -1.0f;
        segments.push_back({world(randomLocal(0, 1)) - direction * 2.0f, direction, 5});
    }
    return segments;
}

}  // namespace metrolux::core::test
