#include "io/curve_mesh.h"

#include "base/error.h"

#include <algorithm>
#include <charconv>
#include <numbers>
#include <utility>

namespace metrolux::core {
namespace {

constexpr double kPi2 = 2 * std::numbers::pi;
/// How far a curve may turn from ring to ring, radians.
constexpr double kTurn = 0.2;
constexpr int kMostSteps = 16;
/// Mitres of sharper bends are cut off: so many radii along the tube.
constexpr double kLongestMitre = 2;

Vec3d anyNormalTo(const Vec3d& t) {
    return t.cross(std::abs(t.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).normalized();
}

/// An axis of the ring before, turned as little as possible into the plane of this one.
Vec3d transported(const Vec3d& axis, const Vec3d& along) {
    const Vec3d rest = axis - along * axis.dot(along);
    return rest.length() > 1e-6 ? rest.normalized() : anyNormalTo(along);
}

double angleBetween(const Vec3d& a, const Vec3d& b) { return std::atan2(a.cross(b).length(), a.dot(b)); }

CurvePoint at(const CurveSpan& s, double t) {
    const double r = 1 - t;
    return r * r * r * s[0] + 3 * r * r * t * s[1] + 3 * r * t * t * s[2] + t * t * t * s[3];
}
CurvePoint derivativeAt(const CurveSpan& s, double t) {
    const double r = 1 - t;
    const auto step = [&](size_t i) { return s[i + 1] + -1 * s[i]; };
    return 3 * r * r * step(0) + 6 * r * t * step(1) + 3 * t * t * step(2);
}

int stepsOf(const CurveSpan& s) {
    double turn = 0;
    for (size_t i = 0; i < 2; ++i) turn += angleBetween(s[i + 1].p - s[i].p, s[i + 2].p - s[i + 1].p);
    double widest = 0, uneven = 0;
    for (size_t i = 0; i < 4; ++i) {
        const double w = double(i) / 3;
        widest = std::max(widest, s[i].radius);
        uneven = std::max(uneven, std::abs(s[i].radius - ((1 - w) * s[0].radius + w * s[3].radius)));
    }
    const int least = uneven > 0.01 * widest ? 4 : 1;
    return std::clamp(static_cast<int>(std::ceil(turn / kTurn)), least, kMostSteps);
}

}  // namespace

CurvePoint operator+(const CurvePoint& a, const CurvePoint& b) { return {a.p + b.p, a.radius + b.radius}; }
CurvePoint operator*(double factor, const CurvePoint& a) { return {a.p * factor, a.radius * factor}; }

std::vector<CurveSpan> spansOfBSpline(std::span<const CurvePoint> points) {
    std::vector<CurveSpan> result;
    for (size_t i = 0; i + 3 < points.size(); ++i) {
        const CurvePoint* p = &points[i];
        const auto third = [&](size_t a, size_t b) { return (2.0 / 3) * p[a] + (1.0 / 3) * p[b]; };
        const CurvePoint inner0 = third(1, 2), inner1 = third(2, 1);
        result.push_back({0.5 * (third(1, 0) + inner0), inner0, inner1, 0.5 * (inner1 + third(2, 3))});
    }
    return result;
}

TubeMesh::TubeMesh(size_t points) : sides_(points > 500'000 ? 5 : points > 100'000 ? 8 : 12) {}

size_t TubeMesh::bytes() const {
    return mesh_->positions.size() * (2 * sizeof(Vec3f) + sizeof(Vec2f)) +
           mesh_->indices.size() * sizeof(uint32_t);
}

void TubeMesh::addRing(const Ring& ring, const Vec3d& axis) {
    const Vec3d other = ring.along.cross(axis);
    const double step = kPi2 / sides_, wider = step / 2 / std::sin(step / 2);
    for (int i = 0; i <= sides_; ++i) {  // the first once more, with its own u
        const double phi = (i % sides_) * step;
        const Vec3d out = axis * std::cos(phi) + other * std::sin(phi);
        const Vec3d offset = out * (ring.radius * wider);
        const double limit = kLongestMitre * ring.radius;
        const double slide = std::clamp(-offset.dot(ring.cut) / ring.along.dot(ring.cut), -limit, limit);
        mesh_->positions.emplace_back(ring.center + offset + ring.along * slide);
        mesh_->normals.emplace_back((out - ring.along * ring.slope).normalized());
        mesh_->uvs.emplace_back(static_cast<float>(double(i) / sides_), static_cast<float>(ring.position));
    }
}

void TubeMesh::join() {
    const auto row = static_cast<uint32_t>(sides_ + 1), last = static_cast<uint32_t>(mesh_->positions.size());
    for (uint32_t i = 0; i + 1 < row; ++i) {
        const uint32_t c = last - row + i, a = c - row;
        mesh_->indices.insert(mesh_->indices.end(), {a, a + 1, c + 1, a, c + 1, c});
    }
}

void TubeMesh::addSmooth(std::span<const CurveSpan> spans) {
    Vec3d axis(0.0), along(0.0);
    bool isFirst = true;
    for (size_t k = 0; k < spans.size(); ++k) {
        const int steps = stepsOf(spans[k]);
        for (int i = k == 0 ? 0 : 1; i <= steps; ++i) {
            const double t = double(i) / steps;
            const CurvePoint here = at(spans[k], t), forward = derivativeAt(spans[k], t);
            const double speed = forward.p.length();
            // Where control points coincide the curve stands still: it goes on as before.
            if (speed > 0)
                along = forward.p / speed;
            else if (isFirst)
                along = (spans[k][3].p - spans[k][0].p).normalized();
            if (!(along.length() > 0)) continue;
            axis = isFirst ? anyNormalTo(along) : transported(axis, along);
            addRing({here.p, along, along, std::max(here.radius, 0.0), speed > 0 ? forward.radius / speed : 0,
                     (double(k) + t) / double(spans.size())},
                    axis);
            if (!isFirst) join();
            isFirst = false;
        }
    }
}

void TubeMesh::addLinear(std::span<const CurvePoint> points) {
    std::vector<CurvePoint> kept;
    for (const CurvePoint& point : points)
        if (kept.empty() || (point.p - kept.back().p).length() > 0) kept.push_back(point);
    Vec3d axis(0.0);
    const auto direction = [&](size_t i) { return (kept[i + 1].p - kept[i].p).normalized(); };
    for (size_t i = 0; i + 1 < kept.size(); ++i) {
        const Vec3d along = direction(i);
        axis = i == 0 ? anyNormalTo(along) : transported(axis, along);
        const double length = (kept[i + 1].p - kept[i].p).length();
        const double slope = (kept[i + 1].radius - kept[i].radius) / length;
        // Halfway to the piece before or after, unless that comes straight back.
        const auto cut = [&](size_t joint) {
            if (joint == 0 || joint + 1 == kept.size()) return along;
            const Vec3d middle = direction(joint - 1) + direction(joint);
            return middle.length() > 1e-3 ? middle.normalized() : along;
        };
        const double parts = double(kept.size() - 1);
        addRing({kept[i].p, along, cut(i), kept[i].radius, slope, double(i) / parts}, axis);
        addRing({kept[i + 1].p, along, cut(i + 1), kept[i + 1].radius, slope, double(i + 1) / parts}, axis);
        join();
    }
}

std::vector<std::vector<CurvePoint>> readCurves(const std::filesystem::path& path, const MeshOptions& options,
                                                std::optional<double> radius) {
    const int numbers = radius ? 3 : 4;
    const char* const line = radius ? "\"x y z\" of a point" : "\"x y z radius\" of a control point";
    const std::string text = readMeshFile(path, options);
    // Two bytes of a line can stand for no more than a point.
    requireMemory(path, options, text.size(), sizeof(CurvePoint) / 2, "the curves");
    std::vector<std::vector<CurvePoint>> result;
    bool isOpen = false;
    int number = 0;
    for (size_t start = 0; start < text.size(); ++number) {
        const size_t end = std::min(text.find('\n', start), text.size());
        const char *at = text.data() + start, *const stop = text.data() + end;
        start = end + 1;
        double values[4];
        int count = 0;
        for (;;) {
            while (at < stop && (*at == ' ' || *at == '\t' || *at == '\r' || *at == ',')) ++at;
            if (at == stop) break;
            double value = 0;
            const auto [rest, problem] = std::from_chars(at, stop, value);
            if (problem != std::errc() || !std::isfinite(value) || count == numbers)
                throw Error("{}:{}: expected {}", path.string(), number + 1, line);
            values[count++] = value;
            at = rest;
        }
        if (count == 0) {
            isOpen = false;
            continue;
        }
        if (radius) values[3] = *radius;
        if (count != numbers || !(values[3] >= 0))
            throw Error("{}:{}: found {} numbers, expected {}{}", path.string(), number + 1, count, line,
                        radius ? "" : ", the radius not negative");
        if (!std::exchange(isOpen, true)) result.emplace_back();
        result.back().push_back({{values[0], values[1], values[2]}, values[3]});
    }
    return result;
}

}  // namespace metrolux::core
