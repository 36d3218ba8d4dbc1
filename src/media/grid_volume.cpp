/// Rays march through the cells of the grid's base, which is its unit cube; other places are mapped into it.

#include "media/grid_volume.h"

#include "base/error.h"
#include "media/grid_axis.h"
#include "media/grid_sums.h"

#include <array>
#include <vector>

namespace metrolux::core {
namespace {

/// Periods of a repeated grid within its bounds; more are refused, as a ray would take forever.
constexpr double kMostPeriods = 4096;

template <int Channels>
class GridVolume final : public Volume {
  public:
    GridVolume(GridSamples samples, const GridSettings& settings)
        : settings_(settings),
          values_(std::move(samples.values)),
          axes_{GridAxis(samples.resolution.x, Channels, settings),
                GridAxis(samples.resolution.y, size_t(Channels) * size_t(samples.resolution.x), settings),
                GridAxis(samples.resolution.z,
                         size_t(Channels) * size_t(samples.resolution.x) * size_t(samples.resolution.y),
                         settings)},
          bounds_(boundsOfUnitCube(settings.toWorld, "gridvolume")) {
        const Transform toLocal = settings.toWorld.inverse();
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 4; ++column)
                toGrid_[row][column] = axes_[row].period * toLocal.at(row, column);
            toGrid_[row][3] += axes_[row].low;
        }
        refuseThinGrids(toLocal);
        findMaximum();
        findUniformBlocks();
    }

    Rgb value(const Vec3f& p) const override {
        const Vec3d place = pointToGrid(p);
        Vec3d inside;
        Imath::V3i cell;
        for (int a = 0; a < 3; ++a) {
            const GridAxis& axis = axes_[a];
            const double periods = (place[a] - axis.low) / axis.period;
            // Points on the faces may have been rounded.
            if (settings_.placement == GridPlacement::Nodes && !(periods > -1e-4 && periods < 1 + 1e-4))
                return Rgb(0.0f);
            inside[a] = Mirrored(*this, a, zoneOf(periods)).place(place[a]);
            cell[a] = static_cast<int>(std::clamp(std::floor(inside[a]), 0.0, axis.cells - 1.0));
            inside[a] = std::clamp(inside[a] - cell[a], 0.0, 1.0);
        }
        if (settings_.filter == GridFilter::Nearest) return rgb(sampleOf(cell));
        float result[Channels];
        const auto corners = cornersOf(cell);
        for (int c = 0; c < Channels; ++c) {
            float corner[kCorners];
            for (int k = 0; k < kCorners; ++k) corner[k] = values_[corners[k] + size_t(c)];
            result[c] = trilinear(corner, float(inside.x), float(inside.y), float(inside.z));
        }
        return rgb(result);
    }
    Rgb integral(const Vec3f& origin, const Vec3f& direction, double begin, double end) const override {
        GridIntegral<Channels> result;
        march(origin, direction, begin, end, result);
        return rgb(result.sum);
    }
    std::optional<Crossing> cross(const Vec3f& origin, const Vec3f& direction, double begin, double end,
                                  int channel, double target) const override {
        GridSearch<Channels> search;
        search.channel = Channels == 1 ? 0 : channel;
        search.target = target;
        march(origin, direction, begin, end, search);
        if (!search.distance) return std::nullopt;
        return Crossing{*search.distance, rgb(search.sum)};
    }
    Rgb maximum() const override { return maximum_; }
    Imath::Box3d bounds() const override { return bounds_; }

  private:
    template <class Real>
    static Rgb rgb(const Real* value) {
        const auto of = [&](int c) { return static_cast<float>(value[Channels == 1 ? 0 : c]); };
        return {of(0), of(1), of(2)};
    }
    Vec3d pointToGrid(const Vec3f& p) const {
        Vec3d result;
        for (int a = 0; a < 3; ++a)
            result[a] = toGrid_[a][0] * p.x + toGrid_[a][1] * p.y + toGrid_[a][2] * p.z + toGrid_[a][3];
        return result;
    }
    Vec3d vectorToGrid(const Vec3f& v) const {
        Vec3d result;
        for (int a = 0; a < 3; ++a)
            result[a] = toGrid_[a][0] * v.x + toGrid_[a][1] * v.y + toGrid_[a][2] * v.z;
        return result;
    }

    /// Space along an axis is divided into zones like the unit cube, which is zone 0. A clamped grid has
    /// three.
    int mostZone() const {
        return settings_.wrap == GridWrap::Clamp ? 1 : static_cast<int>(kMostPeriods) * 2;
    }
    int zoneOf(double periods) const {
        if (settings_.placement == GridPlacement::Nodes) return 0;
        const double most = mostZone();
        return static_cast<int>(std::clamp(std::floor(periods), -most, most));
    }
    /// Map of a zone into zone 0: slope * x + shift.
    struct Mirrored {
        double slope = 1, shift = 0;

        Mirrored(const GridVolume& grid, int a, int zone) {
            if (zone == 0) return;
            const GridAxis& axis = grid.axes_[a];
            if (grid.settings_.wrap == GridWrap::Clamp) {
                slope = 0;
                shift = zone < 0 ? axis.low : axis.low + axis.period;
            } else if (grid.settings_.wrap == GridWrap::Mirror && zone % 2 != 0) {
                slope = -1;
                shift = 2 * axis.low + (zone + 1) * axis.period;
            } else {
                shift = -zone * axis.period;
            }
        }
        double place(double x) const { return slope * x + shift; }
    };

    template <class Visitor>
    void march(const Vec3f& origin, const Vec3f& direction, double begin, double end,
               Visitor& visitor) const {
        const LatticeRay ray(pointToGrid(origin), vectorToGrid(direction));
        // In units of zones.
        Vec3d o, d;
        bool isInside = true;
        for (int a = 0; a < 3; ++a) {
            o[a] = (ray.origin[a] - axes_[a].low) / axes_[a].period;
            d[a] = ray.direction[a] / axes_[a].period;
            constexpr double kRounding = 1e-9;
            for (const double t : {begin, end}) {
                const double x = o[a] + d[a] * t;
                isInside = isInside && x > -kRounding && x < 1 + kRounding;
            }
        }
        if (isInside) {
            marchBase(ray, begin, end, visitor);
            return;
        }
        if (settings_.placement == GridPlacement::Nodes) {
            for (int a = 0; a < 3; ++a) {
                if (d[a] == 0 && (o[a] < 0 || o[a] > 1)) return;
                if (d[a] == 0) continue;
                const double low = -o[a] / d[a], high = (1 - o[a]) / d[a];
                begin = std::max(begin, std::min(low, high));
                end = std::min(end, std::max(low, high));
            }
            if (begin < end) marchBase(ray, begin, end, visitor);
            return;
        }
        const Imath::V3i most(mostZone());
        walkLattice(LatticeRay(o, d), 1, -most, most, begin, end,
                    [&](const Imath::V3i& zone, double entry, double exit) {
                        Vec3d mappedOrigin, mappedDirection;
                        for (int a = 0; a < 3; ++a) {
                            const Mirrored map(*this, a, zone[a]);
                            mappedOrigin[a] = map.place(ray.origin[a]);
                            mappedDirection[a] = map.slope * ray.direction[a];
                        }
                        return marchBase(LatticeRay(mappedOrigin, mappedDirection), entry, exit, visitor);
                    });
    }
    /// Within zone 0: block by block, and cell by cell in those blocks that are not uniform.
    template <class Visitor>
    bool marchBase(const LatticeRay& ray, double begin, double end, Visitor& visitor) const {
        const Imath::V3i blocks(axes_[0].blocks(), axes_[1].blocks(), axes_[2].blocks());
        const auto inBlock = [&](const Imath::V3i& block, double entry, double exit) {
            if (isUniform_[blockIndex(block)]) return visitor.uniform(sampleOf(block * kBlock), entry, exit);
            const CellRun run(ray, entry, exit);
            if (settings_.filter == GridFilter::Nearest) {
                for (int i = 0; i < run.count; ++i)
                    if (!visitor.uniform(sampleOf({run.x[i], run.y[i], run.z[i]}), run.distance[i],
                                         run.distance[i + 1]))
                        return false;
                return true;
            }
            RunSamples<Channels> samples;
            for (int i = 0; i < run.padded; ++i) {
                const auto corners = cornersOf({run.x[i], run.y[i], run.z[i]});
                for (int k = 0; k < kCorners; ++k)
                    for (int c = 0; c < Channels; ++c)
                        samples.corner[c][k][i] = values_[corners[k] + size_t(c)];
            }
            return visitor.cells(run, ray, samples);
        };
        return walkLattice(ray, kBlock, Imath::V3i(0), blocks - Imath::V3i(1), begin, end, inBlock);
    }
    size_t blockIndex(const Imath::V3i& block) const {
        return (size_t(block.z) * size_t(axes_[1].blocks()) + size_t(block.y)) * size_t(axes_[0].blocks()) +
               size_t(block.x);
    }
    /// Of a cell, from -1, in the tables of its axis.
    static size_t entry(int cell) { return static_cast<size_t>(cell) + 1; }
    const float* sampleOf(const Imath::V3i& cell) const {
        return &values_[axes_[0].lower[entry(cell.x)] + axes_[1].lower[entry(cell.y)] +
                        axes_[2].lower[entry(cell.z)]];
    }
    std::array<size_t, kCorners> cornersOf(const Imath::V3i& cell) const {
        const size_t x = entry(cell.x), y = entry(cell.y), z = entry(cell.z);
        const size_t low = axes_[0].lower[x], high = axes_[0].upper[x], y0 = axes_[1].lower[y],
                     y1 = axes_[1].upper[y], z0 = axes_[2].lower[z], z1 = axes_[2].upper[z];
        const size_t rows[4] = {y0 + z0, y1 + z0, y0 + z1, y1 + z1};
        return {rows[0] + low, rows[0] + high, rows[1] + low, rows[1] + high,
                rows[2] + low, rows[2] + high, rows[3] + low, rows[3] + high};
    }

    void refuseThinGrids(const Transform& toLocal) const {
        if (settings_.wrap == GridWrap::Clamp || settings_.placement == GridPlacement::Nodes) return;
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3d p = toLocal.exactPoint(Vec3d(corner & 1 ? bounds_.max.x : bounds_.min.x,
                                                     corner & 2 ? bounds_.max.y : bounds_.min.y,
                                                     corner & 4 ? bounds_.max.z : bounds_.min.z));
            for (int a = 0; a < 3; ++a)
                if (!(std::abs(p[a]) < kMostPeriods))
                    throw Error(
                        "gridvolume: repeats itself {:.3g} times within its bounds, expected {} times at "
                        "most",
                        std::abs(p[a]), kMostPeriods);
        }
    }
    void findMaximum() {
        float most[Channels] = {};
        for (size_t i = 0; i < values_.size(); ++i)
            most[i % Channels] = std::max(most[i % Channels], values_[i]);
        maximum_ = rgb(most);
    }
    void findUniformBlocks() {
        Imath::V3i block;
        for (block.z = 0; block.z < axes_[2].blocks(); ++block.z)
            for (block.y = 0; block.y < axes_[1].blocks(); ++block.y)
                for (block.x = 0; block.x < axes_[0].blocks(); ++block.x)
                    isUniform_.push_back(isUniform(block * kBlock));
    }
    bool isUniform(const Imath::V3i& first) const {
        // Where the samples of the block are: the lower ones of its cells, and the upper ones of the last.
        std::array<std::array<size_t, kBlock + 1>, 3> places;
        std::array<size_t, 3> counts;
        for (int a = 0; a < 3; ++a) {
            const GridAxis& axis = axes_[size_t(a)];
            const auto last = static_cast<size_t>(std::min(first[a] + kBlock, axis.cells)),
                       from = size_t(first[a]);
            counts[size_t(a)] = last - from + 1;
            for (size_t cell = from; cell < last; ++cell)
                places[size_t(a)][cell - from] = axis.lower[cell + 1];
            places[size_t(a)][last - from] = axis.upper[last];
        }
        const float* const value = sampleOf(first);
        for (size_t z = 0; z < counts[2]; ++z)
            for (size_t y = 0; y < counts[1]; ++y)
                for (size_t x = 0; x < counts[0]; ++x)
                    for (size_t c = 0; c < Channels; ++c)
                        if (values_[places[2][z] + places[1][y] + places[0][x] + c] != value[c]) return false;
        return true;
    }

    GridSettings settings_;
    UninitializedVector<float> values_;
    std::array<GridAxis, 3> axes_;
    double toGrid_[3][4];
    Imath::Box3d bounds_;
    Rgb maximum_{0.0f};
    std::vector<uint8_t> isUniform_;  ///< block by block, x fastest
};

}  // namespace

void checkSamples(const GridSamples& samples, SampleRange range) {
    if (samples.channels != 1 && samples.channels != 3)
        throw Error("gridvolume: has {} channels, expected 1 or 3", samples.channels);
    const size_t channels = static_cast<size_t>(samples.channels);
    size_t count = channels;
    bool fits = true;
    for (int a = 0; a < 3; ++a) {
        const int n = samples.resolution[a];
        if (n < 1 || n > (1 << 30))
            throw Error("gridvolume: has {} samples along axis {}, expected 1 to 2^30", n, "xyz"[a]);
        fits = fits && count <= samples.values.size() / static_cast<size_t>(n);
        if (fits) count *= static_cast<size_t>(n);
    }
    if (!fits || count != samples.values.size())
        throw Error("gridvolume: has {} values, expected {} x {} x {} of {} channels", samples.values.size(),
                    samples.resolution.x, samples.resolution.y, samples.resolution.z, samples.channels);
    const float least = range == SampleRange::Signed ? std::numeric_limits<float>::lowest() : 0;
    const auto isBad = [least](float value) {
        return !(value >= least && value <= std::numeric_limits<float>::max());
    };
    const auto bad = std::find_if(samples.values.begin(), samples.values.end(), isBad);
    if (bad == samples.values.end()) return;
    const auto at = static_cast<size_t>(bad - samples.values.begin()), cell = at / channels,
               nx = static_cast<size_t>(samples.resolution.x), ny = static_cast<size_t>(samples.resolution.y);
    throw Error(
        "gridvolume: found {} in cell ({}, {}, {}), channel {} (counted from 0), expected finite numbers{}",
        *bad, cell % nx, cell / nx % ny, cell / nx / ny, at % channels,
        range == SampleRange::Signed ? "" : " that are not negative");
}

VolumePtr makeGridVolume(GridSamples samples, const GridSettings& settings) {
    checkSamples(samples);
    const Imath::V3i& n = samples.resolution;
    if (settings.placement == GridPlacement::Nodes && std::min({n.x, n.y, n.z}) < 2)
        throw Error("gridvolume: has {} x {} x {} samples, expected two at least along each axis", n.x, n.y,
                    n.z);
    if (settings.placement == GridPlacement::Nodes && settings.filter != GridFilter::Trilinear)
        throw Error("gridvolume: samples on the faces of the cube are interpolated linearly alone");
    if (samples.channels == 1) return std::make_shared<GridVolume<1>>(std::move(samples), settings);
    return std::make_shared<GridVolume<3>>(std::move(samples), settings);
}

uint64_t gridVolumeBytes(const Imath::V3i& resolution) {
    uint64_t blocks = 1, tables = 0;
    for (int a = 0; a < 3; ++a) {
        const auto cells = static_cast<uint64_t>(resolution[a]) + 3;
        blocks *= (cells + kBlock - 1) / kBlock;
        tables += cells * 2 * sizeof(size_t);
    }
    return blocks + tables;
}

}  // namespace metrolux::core
