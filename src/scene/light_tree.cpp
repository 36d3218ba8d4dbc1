#include "scene/light_tree.h"

#include "base/error.h"

#include <bit>

namespace metrolux::core {

namespace {

/// Share of choice by intensity that is spread evenly: what is known of a light's intensity may be far off (a
/// texture's mean).
constexpr double kEvenShare = 0.1;
/// Clusters are replaced by their children at less than this squared distance, in squared radii.
constexpr float kNear2 = 2;
/// With no more lights than this all clusters are replaced, so that each light has its own estimate.
constexpr size_t kFewLights = 64;
/// With more lights than this memory counts: half of it, for a choice that is as good.
constexpr size_t kManyLights = 1000;
/// A cluster's cosine is at least this share of the largest that any of its lights can have.
constexpr float kBoundShare = 0.1f;
/// Mean over all directions of max(cos, 0): what a cluster sends of which nothing but the intensity is known.
constexpr float kMeanCosine = 0.25f;
/// No cosine counts as less than this, nor as zero by what rounding adds or takes.
constexpr float kLeastCosine = 1e-3f;
constexpr float kCosineMargin = 1e-5f;
/// Rounding of coordinates, relative to the largest.
constexpr float kCoordinateMargin = 4e-7f;
/// Distances below this share of the whole tree's radius count as this, and the square never as less than
/// kLeastDistance2: weights stay finite.
constexpr float kLeastDistance = 1e-5f;
constexpr float kLeastDistance2 = 1e-30f;

// Not std::max, whose references keep compilers from working on all children at once.
inline float larger(float a, float b) { return a > b ? a : b; }
inline float smaller(float a, float b) { return a < b ? a : b; }

/// What a set of lights adds up to. The direction is the sum of the lights' mean directions, times intensity;
/// a light that emits everywhere has none.
struct Sum {
    Vec3f lower{kInfinity}, upper{-kInfinity};
    Imath::V3d direction{0.0};
    double lengths = 0;  ///< of the directions summed
    double intensity = 0;
    float cosEmission = 1;
    size_t count = 0;

    Sum() = default;
    explicit Sum(const LightBounds& b)
        : lower(b.lower),
          upper(b.upper),
          lengths(double(b.intensity) * 0.5 * (1 + double(b.normals.cosine))),
          intensity(b.intensity),
          cosEmission(b.cosEmission),
          count(1) {
        const Vec3f& a = b.normals.axis;
        direction = Imath::V3d(a.x, a.y, a.z) * lengths;
    }
    void add(const Sum& s) {
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], s.lower[axis]);
            upper[axis] = std::max(upper[axis], s.upper[axis]);
        }
        direction += s.direction;
        lengths += s.lengths;
        intensity += s.intensity;
        cosEmission = std::min(cosEmission, s.cosEmission);
        count += s.count;
    }
    /// Whether the directions are one (1) or cancel (0).
    double alignment() const { return lengths > 0 ? std::min(direction.length() / lengths, 1.0) : 1.0; }
};

Vec3f center(const LightBounds& b) { return b.lower + (b.upper - b.lower) * 0.5f; }

/// Measure of the directions into which a cone of normals emits [Conty Estevez & Kulla 2018, 4.1]: solid
/// angle of the normals and, weighted by the cosine to the nearest of them, of the rim within the emission
/// angle.
double emissionMeasure(double cosNormals, double cosEmission) {
    const double o = std::acos(std::clamp(cosNormals, -1.0, 1.0));
    const double e = std::acos(std::clamp(cosEmission, -1.0, 1.0));
    const double w = std::min(o + e, std::numbers::pi), sinO = std::sin(o);
    return 2 * std::numbers::pi * (1 - cosNormals) +
           0.5 * std::numbers::pi * (2 * w * sinO - std::cos(o - 2 * w) - 2 * o * sinO + cosNormals);
}

/// Cost of a cluster: how much of what it is expected to send is uncertain (their surface area orientation
/// heuristic, with the area of the sphere, which is not zero where lights lie in a line). The normals are
/// taken for a cap with the same mean direction.
double cost(const Sum& s) {
    if (!(s.intensity > 0)) return 0;
    const double spread = std::min(2 * s.direction.length() / s.intensity - 1, 1.0);
    return s.intensity * double(lengthSquared(s.upper - s.lower)) * emissionMeasure(spread, s.cosEmission);
}

/// In an order that does not make one addition wait for seven others.
double total(const std::array<float, 8>& w) {
    const double a = double(w[0]) + double(w[1]), b = double(w[2]) + double(w[3]);
    const double c = double(w[4]) + double(w[5]), d = double(w[6]) + double(w[7]);
    return (a + b) + (c + d);
}

/// The interval that u falls into, of some laid end to end whose lengths, not negative, have this sum. Empty
/// ones are never met. `u` is rescaled to its position there.
template <class Lengths>
int pick(const Lengths& lengths, int count, double sum, double& u) {
    const double target = u * sum;
    double below = 0;
    int chosen = -1;
    for (int i = 0; i < count; ++i) {
        if (!(lengths[i] > 0)) continue;
        if (chosen >= 0) below += double(lengths[chosen]);
        chosen = i;
        if (target < below + double(lengths[i])) break;
    }
    u = std::clamp((target - below) / double(lengths[chosen]), 0.0, 1 - 0x1p-53);
    return chosen;
}

}  // namespace

/// Builds from the top: a node's range of lights is divided in two until there are eight parts, each time the
/// one of largest cost at the best of some planes.
struct LightTree::Builder {
    struct Record {
        LightBounds bounds;
        Vec3f center;
        uint32_t index;
    };
    struct Range {
        size_t first = 0, last = 0;
        Sum sum;
        double cost = 0;
        size_t size() const { return last - first; }
    };

    LightTree& tree;
    std::vector<Record> records;
    float nearest2 = 0;

    Range range(size_t first, size_t last) const {
        Range r{first, last, {}, 0};
        for (size_t i = first; i < last; ++i) r.sum.add(Sum(records[i].bounds));
        r.cost = metrolux::core::cost(r.sum);
        return r;
    }

    /// `path`: the children taken from the root to here.
    uint32_t build(const Range& whole, int level, uint64_t path) {
        const auto index = static_cast<uint32_t>(tree.nodes_.size());
        tree.nodes_.emplace_back();
        const std::vector<Range> parts = divide(whole, level);
        for (size_t k = 0; k < parts.size(); ++k) {
            const uint64_t below = path | uint64_t(k) << (kBitsPerLevel * level);
            uint32_t child = 0;
            if (parts[k].size() == 1) {
                const uint32_t light = records[parts[k].first].index;
                tree.paths_[light] = below;
                child = light | kIsLight;
            } else {
                child = build(parts[k], level + 1, below);
            }
            fill(tree.nodes_[index], k, parts[k], child);
        }
        return index;
    }

    /// In the order of their planes, so that a small step of u picks a near light.
    std::vector<Range> divide(const Range& whole, int level) {
        const bool few = tree.size() <= kFewLights;
        // Equal parts when the levels that are left would just do, or when the cut will hold all anyway.
        const bool even = few || whole.size() > size_t{1}
                                                    << std::min(kBitsPerLevel * (kMaxLevels - level - 1), 62);
        // A part that a single node can hold may be left to it: nodes are filled better.
        const bool fill = few || tree.size() > kManyLights;
        const size_t least = fill && whole.size() > kWidth ? kWidth : 1;
        std::vector<Range> parts{whole};
        while (parts.size() < kWidth) {
            const auto worse = [&](const Range& a, const Range& b) {
                if ((a.size() > least) != (b.size() > least)) return b.size() > least;
                return even || a.cost == b.cost ? a.size() < b.size() : a.cost < b.cost;
            };
            const auto next = std::max_element(parts.begin(), parts.end(), worse);
            if (next->size() <= least) break;
            const Range r = *next;
            const size_t middle = even || r.size() == 2 ? halve(r) : split(r);
            *next = range(r.first, middle);
            parts.insert(next + 1, range(middle, r.last));
        }
        return parts;
    }

    static int widestAxis(const Vec3f& extent) {
        return extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    }

    size_t halve(const Range& r) {
        const int axis = widestAxis(r.sum.upper - r.sum.lower);
        const size_t middle = r.first + r.size() / 2;
        const auto at = [&](size_t i) { return records.begin() + static_cast<ptrdiff_t>(i); };
        std::nth_element(at(r.first), at(middle), at(r.last), [&](const Record& a, const Record& b) {
            return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.index < b.index;
        });
        return middle;
    }

    /// Slabs of equal thickness between the outermost centers.
    struct Slabs {
        static constexpr int kCount = 12;
        Vec3f lower{kInfinity}, upper{-kInfinity};

        int of(const Vec3f& c, int axis) const {
            const float position = (c[axis] - lower[axis]) / (upper[axis] - lower[axis]) * float(kCount);
            return position > 0 ? static_cast<int>(std::min(position, float(kCount - 1))) : 0;
        }
    };
    struct Plane {
        double cost = std::numeric_limits<double>::infinity();
        int axis = -1, slab = 0;  ///< the first slab above
    };

    size_t split(const Range& r) {
        Slabs slabs;
        for (size_t i = r.first; i < r.last; ++i)
            for (int axis = 0; axis < 3; ++axis) {
                slabs.lower[axis] = std::min(slabs.lower[axis], records[i].center[axis]);
                slabs.upper[axis] = std::max(slabs.upper[axis], records[i].center[axis]);
            }
        const Plane plane = bestPlane(r, slabs);
        if (plane.axis < 0) return halve(r);  // all at one point
        const auto middle =
            std::partition(records.begin() + static_cast<ptrdiff_t>(r.first),
                           records.begin() + static_cast<ptrdiff_t>(r.last),
                           [&](const Record& a) { return slabs.of(a.center, plane.axis) < plane.slab; });
        return static_cast<size_t>(middle - records.begin());
    }

    Plane bestPlane(const Range& r, const Slabs& slabs) const {
        std::array<std::array<Sum, Slabs::kCount>, 3> sums;
        for (size_t i = r.first; i < r.last; ++i) {
            const Sum light(records[i].bounds);
            for (int axis = 0; axis < 3; ++axis)
                if (slabs.upper[axis] > slabs.lower[axis])
                    sums[axis][slabs.of(records[i].center, axis)].add(light);
        }

        const Vec3f extent = slabs.upper - slabs.lower;
        const float widest = extent[widestAxis(extent)];
        Plane best;
        for (int axis = 0; axis < 3; ++axis) {
            if (!(extent[axis] > 0)) continue;
            std::array<double, Slabs::kCount> above{};
            Sum sum;
            for (int k = Slabs::kCount; k-- > 1;) {
                const bool empty = sums[axis][k].count == 0;
                if (!empty) sum.add(sums[axis][k]);
                above[k] = empty && k + 1 < Slabs::kCount ? above[k + 1] : metrolux::core::cost(sum);
            }
            Sum below;
            for (int k = 1; k < Slabs::kCount; ++k) {
                if (sums[axis][k - 1].count == 0) continue;  // the plane before is the same
                below.add(sums[axis][k - 1]);
                if (below.count == r.size()) break;
                // Thin boxes are not to become thinner (4.3).
                const double c = (metrolux::core::cost(below) + above[k]) * double(widest / extent[axis]);
                if (c < best.cost) best = {c, axis, k};
            }
        }
        return best;
    }

    void fill(Node& node, size_t k, const Range& part, uint32_t child) const {
        const Sum& s = part.sum;
        const Vec3f c = s.lower + (s.upper - s.lower) * 0.5f;
        float coordinate = 0;
        for (int axis = 0; axis < 3; ++axis)
            coordinate = std::max({coordinate, std::abs(s.lower[axis]), std::abs(s.upper[axis])});
        const float radius =
            0.5f * (s.upper - s.lower).length() * (1 + kCoordinateMargin) + kCoordinateMargin * coordinate;
        const DirectionCone normals = cone(part);
        node.x[k] = c.x, node.y[k] = c.y, node.z[k] = c.z;
        node.radius2[k] = sqr(radius);
        node.nearest2[k] = std::max(sqr(radius), nearest2);
        node.axisX[k] = normals.axis.x, node.axisY[k] = normals.axis.y, node.axisZ[k] = normals.axis.z;
        node.cosNormals[k] = normals.cosine;
        node.sinNormals[k] = safeSqrt(1 - sqr(normals.cosine));
        node.cosEmission[k] = s.cosEmission - kCosineMargin;
        node.alignment[k] = part.size() == 1 ? 1.0f : static_cast<float>(s.alignment());
        node.intensity[k] = static_cast<float>(s.intensity);
        node.child[k] = child;
        if (!(child & kIsLight)) node.inner |= 1u << k;
    }

    /// The mean direction, and the angle about it that holds all.
    DirectionCone cone(const Range& part) const {
        if (part.size() == 1) return records[part.first].bounds.normals;
        const double length = part.sum.direction.length();
        if (!(length > 0)) return {};
        const Imath::V3d mean = part.sum.direction / length;
        DirectionCone result{normalize(Vec3f(float(mean.x), float(mean.y), float(mean.z))), 1};
        for (size_t i = part.first; i < part.last && result.cosine > -1; ++i)
            result.cosine =
                std::min(result.cosine, cosineAround(result.axis, records[i].bounds.normals) - 1e-6f);
        result.cosine = std::max(result.cosine, -1.0f);
        return result;
    }
};

LightTree::LightTree(std::span<const LightBounds> lights) {
    if (lights.size() >= kIsLight)
        throw Error("light tree: {} lights, expected fewer than {}", lights.size(), kIsLight);
    if (lights.empty()) return;
    for (const LightBounds& b : lights) totalIntensity_ += double(b.intensity);
    const double even = 1.0 / double(lights.size());

    paths_.resize(lights.size());
    Builder builder{*this, {}, 0};
    builder.records.reserve(lights.size());
    for (const LightBounds& b : lights) {
        const double share = totalIntensity_ > 0 ? double(b.intensity) / totalIntensity_ : even;
        LightBounds relative = b;
        relative.intensity = static_cast<float>((1 - kEvenShare) * share + kEvenShare * even);
        builder.records.push_back({relative, center(b), static_cast<uint32_t>(builder.records.size())});
    }
    const Builder::Range whole = builder.range(0, lights.size());
    const float radius = 0.5f * (whole.sum.upper - whole.sum.lower).length();
    builder.nearest2 = std::max(sqr(kLeastDistance * radius), kLeastDistance2);
    builder.build(whole, 0, 0);
}

/// Estimates for the children of what they send to x, relative to the intensity of all lights. Returns the
/// bits of those that x is near to.
uint32_t LightTree::estimate(const Node& node, const Vec3f& x, float near2, Lanes& weights) {
    const float px = x.x, py = x.y, pz = x.z;
    Lanes result;
    uint32_t near = 0;
    for (int k = 0; k < kWidth; ++k) {
        const float dx = px - node.x[k], dy = py - node.y[k], dz = pz - node.z[k];
        const float distance2 = dx * dx + dy * dy + dz * dz;
        const float inverse = 1 / larger(distance2, kLeastDistance2);
        const float along = dx * node.axisX[k] + dy * node.axisY[k] + dz * node.axisZ[k];
        const float cosine = smaller(larger(along * std::sqrt(inverse), -1.0f), 1.0f);
        // The angle to the nearest of the normals if all were at the center, and the least that the extent
        // allows.
        const float mean =
            cosOfDifference(cosine, std::sqrt(1 - cosine * cosine), node.cosNormals[k], node.sinNormals[k]);
        const float sinSphere2 = smaller(node.radius2[k] * inverse, 1.0f);
        const float bound = cosOfDifference(mean, std::sqrt(larger(1 - mean * mean, 0.0f)),
                                            std::sqrt(1 - sinSphere2), std::sqrt(sinSphere2));
        const float outside = larger(mean, larger(kBoundShare * bound, kLeastCosine));
        const bool inside = distance2 <= node.radius2[k];
        const float aligned = inside ? 1.0f : outside;
        const float factor = kMeanCosine + node.alignment[k] * (aligned - kMeanCosine);
        const bool shines = inside || bound >= node.cosEmission[k];
        result[k] = shines ? node.intensity[k] * factor / larger(distance2, node.nearest2[k]) : 0.0f;
        near |= distance2 < near2 * node.radius2[k] ? 1u << k : 0u;
    }
    weights = result;
    return near;
}

/// Weights by which a child is chosen; their sum, which is positive.
double LightTree::weigh(const Node& node, const Vec3f& x, Lanes& weights) {
    estimate(node, x, kNear2, weights);
    const double sum = total(weights);
    if (sum > 0) return sum;
    weights = node.intensity;
    return total(weights);
}

LightTree::Cut LightTree::cut(const Vec3f& x) const {
    Cut c;
    c.x = x;
    c.total = 0;
    c.count = 1;
    c.node[0] = 0;
    const float near2 = size() > kFewLights ? kNear2 : std::numeric_limits<float>::max();
    for (int i = 0; i < c.count; ++i) {
        const Node& node = nodes_[c.node[i]];
        Lanes& weights = c.weights[i];
        uint32_t near = estimate(node, x, near2, weights) & node.inner;
        c.firstChild[i] = static_cast<uint8_t>(c.count);
        c.replaced[i] = 0;
        for (; near != 0 && c.count < kMaxExpanded; near &= near - 1) {
            const int k = std::countr_zero(near);
            if (!(weights[k] > 0)) continue;
            c.node[c.count++] = node.child[k];
            c.replaced[i] |= static_cast<uint8_t>(1u << k);
            weights[k] = 0;
        }
        c.sum[i] = total(weights);
        c.total += c.sum[i];
    }
    c.irradiance = c.total * totalIntensity_;
    if (c.total > 0) return c;
    c.irradiance = 0;
    c.count = 1;
    c.replaced[0] = 0;
    c.total = c.sum[0] = weigh(nodes_[0], x, c.weights[0]);
    return c;
}

LightTree::Choice LightTree::sample(const Cut& cut, double& u) const {
    const int i = pick(cut.sum, cut.count, cut.total, u);
    int k = pick(cut.weights[i], kWidth, cut.sum[i], u);
    Choice choice{0, double(cut.weights[i][k]) / cut.total};
    uint32_t child = nodes_[cut.node[i]].child[k];
    while (!(child & kIsLight)) {
        const Node& node = nodes_[child];
        Lanes weights;
        const double sum = weigh(node, cut.x, weights);
        k = pick(weights, kWidth, sum, u);
        choice.probability *= double(weights[k]) / sum;
        child = node.child[k];
    }
    choice.light = child & ~kIsLight;
    return choice;
}

double LightTree::probability(const Cut& cut, uint32_t light) const {
    uint64_t path = paths_[light];
    const auto next = [&] {
        const int k = static_cast<int>(path % kWidth);
        path >>= kBitsPerLevel;
        return k;
    };
    int i = 0, k = next();
    for (; cut.replaced[i] >> k & 1; k = next())
        i = cut.firstChild[i] + std::popcount(cut.replaced[i] & ((1u << k) - 1));
    double p = double(cut.weights[i][k]) / cut.total;
    uint32_t child = nodes_[cut.node[i]].child[k];
    while (!(child & kIsLight) && p > 0) {
        const Node& node = nodes_[child];
        Lanes weights;
        const double sum = weigh(node, cut.x, weights);
        k = next();
        p *= double(weights[k]) / sum;
        child = node.child[k];
    }
    return p;
}

}  // namespace metrolux::core
