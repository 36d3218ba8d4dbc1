#include "io/mitsuba/curves.h"

#include "io/curve_mesh.h"
#include "io/mitsuba/field_of_view.h"

namespace metrolux::core::mitsuba {
namespace {

/// `least`: control points that a curve needs.
template <class Add>
ShapePtr makeCurves(const Element& element, LoadContext& context, size_t least, const Add& add) {
    MeshOptions options;
    options.memory = &context.memory;
    options.toWorld = context.toWorld(element);
    options.flipNormals = element.boolean("flip_normals", false);
    if (!isSimilarity(options.toWorld))
        throw element.error(
            "\"to_world\" of curves may rotate, translate and scale uniformly, found another map");
    const std::filesystem::path file = context.resolve(element, element.requiredString("filename"));
    const std::vector<std::vector<CurvePoint>> curves = readCurves(file, options);
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

}  // namespace

ShapePtr makeBSplineCurve(const Element& element, LoadContext& context) {
    return makeCurves(element, context, 4, [](TubeMesh& tubes, const std::vector<CurvePoint>& curve) {
        tubes.addSmooth(spansOfBSpline(curve));
    });
}

ShapePtr makeLinearCurve(const Element& element, LoadContext& context) {
    return makeCurves(element, context, 2,
                      [](TubeMesh& tubes, const std::vector<CurvePoint>& curve) { tubes.addLinear(curve); });
}

}  // namespace metrolux::core::mitsuba
