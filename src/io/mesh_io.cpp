#include "io/mesh_io.h"

#include "base/error.h"

#include <fstream>
#include <limits>

namespace metrolux::core {

namespace {

/// Allowance for the ray tracing structure of a triangle.
constexpr uint64_t kTreeBytes = 256;

template <class T>
uint64_t bytesOf(const std::vector<T>& data) {
    return data.capacity() * sizeof(T);
}

uint64_t memoryOf(const TriangleMesh& mesh) {
    uint64_t bytes = bytesOf(mesh.positions) + bytesOf(mesh.normals) + bytesOf(mesh.uvs) +
                     bytesOf(mesh.indices) +
                     mesh.primitiveCount() * (sizeof(double) + sizeof(Vec3f) + kTreeBytes);
    for (const TriangleMesh::Attribute& a : mesh.attributes) bytes += bytesOf(a.values);
    return bytes;
}

}  // namespace

void requireMemory(const std::filesystem::path& path, const MeshOptions& options, uint64_t count,
                   uint64_t bytesEach, std::string_view what) {
    if (!options.memory) return;
    const bool overflows = bytesEach > 0 && count > std::numeric_limits<uint64_t>::max() / bytesEach;
    try {
        options.memory->require(overflows ? std::numeric_limits<uint64_t>::max() : count * bytesEach, what);
    } catch (const Error& error) {
        throw Error("{}: {}", path.string(), error.what());
    }
}

std::string readMeshFile(const std::filesystem::path& path, const MeshOptions& options) {
    std::error_code code;
    const auto size = std::filesystem::file_size(path, code);
    std::ifstream stream(path, std::ios::binary);
    if (code || !stream) throw Error("{}: cannot be read", path.string());
    requireMemory(path, options, size, 1, "the file");
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
        if (options.memory) options.memory->take(memoryOf(mesh), "the mesh");
        mesh.finalize();
    } catch (const Error& error) {
        throw Error("{}: {}", path.string(), error.what());
    }
}

}  // namespace metrolux::core
