#include "io/mitsuba/curves.h"

#include "io/curve_mesh.h"
#include "io/hair_file.h"
#include "io/mitsuba/field_of_view.h"

namespace metrolux::core::mitsuba {
namespace {

/// `least`: control points that a curve needs.
template <class Read, class Add>
ShapePtr makeCurves(const Element& element, LoadContext& context, size_t least, const Read& read,
                    const Add& add) {
    MeshOptions options;
    options.memory = &context.memory;
    options.toWorld = context.toWorld(element);
    options.flipNormals = element.boolean("flip_normals", false);
    if (!isSimilarity(options.toWorld))
        throw element.error(
            "\"to_world\" of curves may rotate, translate and scale uniformly, found another map");
    const std::filesystem::path file = context.resolve(element, element.requiredString("filename"));
    const std::vector<std::vector<CurvePoint>> curves = read(file, options);
    size_t points = 0;
    for (const std::vector<CurvePoint>& curve : curves) points += curve.size();
    TubeMesh tubes(points);
    for (const std::vector<CurvePoint>& curve : curves) {
        if (curve.size() < least)
            throw Error("{}: found a curve of {} control points, expected {} at least", file.string(),
                        curve.size(), least);
        add(tubes, curve);
        requireMemory(file, options, tubes.bytes(), 1, "the curves");
    }
    const std::shared_ptr<TriangleMesh> mesh = tubes.take();
    finishMesh(*mesh, file, options);
    return mesh;
}

std::vector<std::vector<CurvePoint>> readThick(const std::filesystem::path& file,
                                               const MeshOptions& options) {
    return readCurves(file, options);
}

void addLinear(TubeMesh& tubes, const std::vector<CurvePoint>& curve) { tubes.addLinear(curve); }

}  // namespace

ShapePtr makeBSplineCurve(const Element& element, LoadContext& context) {
    return makeCurves(element, context, 4, readThick,
                      [](TubeMesh& tubes, const std::vector<CurvePoint>& curve) {
                          tubes.addSmooth(spansOfBSpline(curve));
                      });
}

ShapePtr makeLinearCurve(const Element& element, LoadContext& context) {
    return makeCurves(element, context, 2, readThick, addLinear);
}

ShapePtr makeHair(const Element& element, LoadContext& context) {
    const double radius = element.number("radius", 0.025f);
    if (!(radius > 0))
        throw element.error(fmt::format("found the radius {}, expected a positive one", radius));
    const float reduction = element.number("reduction", 0);
    if (!(reduction >= 0 && reduction < 1))
        throw element.error(fmt::format("found \"reduction\" {}, expected 0 or more and below 1", reduction));
    if (reduction > 0)
        context.warn(element, "\"reduction\" has no effect: all hairs are there, as thin as they are");
    element.ignore("angle_threshold");  // what it leaves out is not seen
    const auto read = [&](const std::filesystem::path& file, const MeshOptions& options) {
        auto hairs = readHairs(file, options, radius);
        std::erase_if(hairs, [](const auto& hair) { return hair.size() < 2; });
        if (hairs.empty()) throw Error("{}: found no hair of two points", file.string());
        return hairs;
    };
    return makeCurves(element, context, 2, read, addLinear);
}

}  // namespace metrolux::core::mitsuba
