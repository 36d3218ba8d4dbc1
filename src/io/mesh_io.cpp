#include "io/mesh_io.h"

#include "base/error.h"

#include <fstream>

namespace metrolux {

std::string readMeshFile(const std::filesystem::path& path) {
    std::error_code code;
    const auto size = std::filesystem::file_size(path, code);
    std::ifstream stream(path, std::ios::binary);
    if (code || !stream) throw Error("{}: cannot be read", path.string());
    std::string text(size, '\0');
    stream.read(text.data(), static_cast<std::streamsize>(size));
    if (static_cast<size_t>(stream.gcount()) != size)
        throw Error("{}: cannot be read in full", path.string());
    return text;
}

void finishMesh(TriangleMesh& mesh, const std::filesystem::path& path, const MeshOptions& options) {
    mesh.id = path.filename().string();
    mesh.flipNormals = options.flipNormals;
    if (mesh.indices.empty()) throw Error("{}: has no faces", path.string());
    for (const uint32_t index : mesh.indices)
        if (index >= mesh.positions.size())
            throw Error("{}: a face refers to vertex {} (counted from 0), but there are {}", path.string(),
                        index, mesh.positions.size());
    if (options.faceNormals) mesh.normals.clear();
    if (!options.toWorld.isIdentity())
        for (Vec3f& p : mesh.positions) p = options.toWorld.point(p);
    for (Vec3f& n : mesh.normals) n = normalize(options.toWorld.normal(n));
    if (mesh.normals.empty() && !options.faceNormals) mesh.computeVertexNormals();
    if (options.flipTexCoords)
        for (Vec2f& uv : mesh.uvs) uv.y = 1.0f - uv.y;
    try {
        mesh.finalize();
    } catch (const Error& error) {
        throw Error("{}: {}", path.string(), error.what());
    }
}

}  // namespace metrolux
