#include "io/pbrt/curves.h"

#include "io/curve_mesh.h"

namespace metrolux::core::pbrt {
namespace {

/// A quadratic piece as a cubic one.
CurveSpan elevated(const CurvePoint& a, const CurvePoint& b, const CurvePoint& c) {
    return {a, (1.0 / 3) * a + (2.0 / 3) * b, (2.0 / 3) * b + (1.0 / 3) * c, c};
}

}  // namespace

std::shared_ptr<TriangleMesh> curveMesh(const Parameters& p, Reading& reading) {
    const std::string type = p.string("type", "flat"), basis = p.string("basis", "bezier");
    if (type != "flat" && type != "cylinder" && type != "ribbon")
        throw p.error(fmt::format("found the type \"{}\", expected flat, cylinder or ribbon", type));
    if (basis != "bezier" && basis != "bspline")
        throw p.error(fmt::format("found the basis \"{}\", expected bezier or bspline", basis));
    if (type == "ribbon") reading.warn(p.error("a ribbon is read as a round tube of its width"));
    p.ignore({"N", "splitdepth"});
    const int64_t degree = p.integer("degree", 3);
    if (degree != 2 && degree != 3)
        throw p.error(fmt::format("found the degree {}, expected 2 or 3", degree));
    const double width = p.number("width", 1), first = p.number("width0", width),
                 last = p.number("width1", width);
    if (!(first >= 0 && last >= 0)) throw p.error("found a negative width, expected zero or more");

    const std::vector<double>& numbers = p.numbers("P", 3);
    const size_t count = numbers.size() / 3, order = static_cast<size_t>(degree);
    const bool isBezier = basis == "bezier";
    if (count < order + 1 || (isBezier && (count - 1) % order != 0))
        throw p.error(fmt::format("found {} control points, expected {}", count,
                                  isBezier ? fmt::format("{} and any multiple of {} more", order + 1, order)
                                           : fmt::format("{} at least", order + 1)));
    reading.memory.take(count * sizeof(CurveSpan), "the curve");
    std::vector<CurvePoint> points;
    for (size_t i = 0; i < count; ++i)
        points.push_back({{numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]}});
    std::vector<CurveSpan> spans;
    if (isBezier) {
        for (size_t i = 0; i + order < count; i += order)
            spans.push_back(order == 3 ? CurveSpan{points[i], points[i + 1], points[i + 2], points[i + 3]}
                                       : elevated(points[i], points[i + 1], points[i + 2]));
    } else if (order == 3) {
        spans = spansOfBSpline(points);
    } else {
        for (size_t i = 0; i + 2 < count; ++i)
            spans.push_back(elevated(0.5 * (points[i] + points[i + 1]), points[i + 1],
                                     0.5 * (points[i + 1] + points[i + 2])));
    }
    // The width changes evenly with the parameter.
    for (size_t k = 0; k < spans.size(); ++k)
        for (size_t i = 0; i < 4; ++i) {
            const double u = (double(k) + double(i) / 3) / double(spans.size());
            spans[k][i].radius = ((1 - u) * first + u * last) / 2;
        }
    TubeMesh tube(points.size());
    tube.addSmooth(spans);
    reading.memory.take(tube.bytes(), "the curve");
    return tube.take();
}

}  // namespace metrolux::core::pbrt
