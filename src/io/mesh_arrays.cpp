#include "io/mesh_arrays.h"

#include "base/error.h"

namespace metrolux::core {
namespace {

constexpr const char* kName = "arrays";  // what messages say in place of a file

/// How many groups of `size` numbers there are.
size_t countOf(const char* what, size_t numbers, size_t size) {
    if (numbers % size != 0)
        throw Error("{}: found {} numbers in \"{}\", expected a multiple of {}", kName, numbers, what, size);
    return numbers / size;
}

void requireCount(const char* what, size_t found, size_t expected) {
    if (found != 0 && found != expected)
        throw Error("{}: found \"{}\" of {} vertices, expected {} or none", kName, what, found, expected);
}

}  // namespace

std::shared_ptr<TriangleMesh> meshOfArrays(const mitsuba::MeshArrays& arrays, const MeshOptions& options) {
    const size_t vertices = countOf("positions", arrays.positions.size(), 3);
    countOf("triangles", arrays.triangles.size(), 3);
    requireCount("normals", countOf("normals", arrays.normals.size(), 3), vertices);
    requireCount("uvs", countOf("uvs", arrays.uvs.size(), 2), vertices);
    requireMemory(kName, options, vertices, 2 * sizeof(Vec3f) + sizeof(Vec2f), "the vertices");
    const auto vectors = [](std::span<const float> numbers) {
        std::vector<Vec3f> result(numbers.size() / 3);
        for (size_t i = 0; i < result.size(); ++i)
            result[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
        return result;
    };
    auto mesh = std::make_shared<TriangleMesh>();
    mesh->positions = vectors(arrays.positions);
    mesh->normals = vectors(arrays.normals);
    for (size_t i = 0; i + 1 < arrays.uvs.size(); i += 2)
        mesh->uvs.emplace_back(arrays.uvs[i], arrays.uvs[i + 1]);
    mesh->indices.assign(arrays.triangles.begin(), arrays.triangles.end());
    for (const mitsuba::MeshArrays::Attribute& a : arrays.attributes) {
        const bool ofFaces = a.name.starts_with("face_");
        if (!ofFaces && !a.name.starts_with("vertex_"))
            throw Error("{}: found the attribute \"{}\", expected a name that begins with vertex_ or face_",
                        kName, a.name);
        if (a.channels != 1 && a.channels != 3)
            throw Error("{}: found {} channels of \"{}\", expected 1 or 3", kName, a.channels, a.name);
        const size_t expected = (ofFaces ? mesh->primitiveCount() : vertices) * size_t(a.channels);
        if (a.values.size() != expected)
            throw Error("{}: found {} numbers in \"{}\", expected {}", kName, a.values.size(), a.name,
                        expected);
        mesh->attributes.push_back({a.name, a.channels, {a.values.begin(), a.values.end()}});
    }
    finishMesh(*mesh, kName, options);
    return mesh;
}

}  // namespace metrolux::core
