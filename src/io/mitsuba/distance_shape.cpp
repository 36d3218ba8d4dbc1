#include "io/mitsuba/distance_shape.h"

#include "io/distance_field.h"
#include "io/mesh_io.h"
#include "io/mitsuba/choice.h"
#include "io/volume_file.h"

namespace metrolux::core::mitsuba {

ShapePtr makeDistanceShape(const Element& element, LoadContext& context) {
    const bool smooth = choice<bool>(element, "normals", {{"smooth", true}, {"analytic", false}});
    MeshOptions options;
    options.memory = &context.memory;
    options.toWorld = context.toWorld(element);
    options.flipNormals = element.boolean("flip_normals", false);
    options.faceNormals = !smooth;
    const std::filesystem::path file = context.resolve(element, element.requiredString("filename"));
    MemoryBudget forReading = context.memory;
    const GridSamples samples = readVolumeFile(file, &forReading, SampleRange::Signed).samples;
    const auto mesh = meshOfDistances(
        samples, smooth, [&](uint64_t bytes) { requireMemory(file, options, bytes, 1, "the surface"); });
    finishMesh(*mesh, file, options);
    return mesh;
}

}  // namespace metrolux::core::mitsuba
