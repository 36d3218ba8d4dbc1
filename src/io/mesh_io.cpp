#include "io/mesh_io.h"

#include "base/error.h"
#include "io/mesh_smoothing.h"

#include <algorithm>
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
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
    return text;
}

void warn(const MeshOptions& options, const std::string& message) {
    if (options.warnings) options.warnings->push_back(message);
}

namespace {

/// A map that mirrors turns the winding inside out; vertex normals do not follow it. Triangles without
/// normals are turned back.
void keepOutside(TriangleMesh& mesh) {
    const auto isZero = [&](uint32_t v) { return mesh.normals[v] == Vec3f(0.0f); };
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        uint32_t* v = &mesh.indices[i];
        if (mesh.normals.empty() || (isZero(v[0]) && isZero(v[1]) && isZero(v[2]))) std::swap(v[1], v[2]);
    }
}

void warnOfLostNormals(const TriangleMesh& mesh, const MeshOptions& options) {
    const auto lost = std::count(mesh.normals.begin(), mesh.normals.end(), Vec3f(0.0f));
    if (lost > 0)
        warn(options,
             fmt::format("{} of {} vertex normals are undefined where to_world flattens the mesh: those "
                         "of the faces stand in",
                         lost, mesh.normals.size()));
}

}  // namespace

void finishMesh(TriangleMesh& mesh, const std::filesystem::path& path, const MeshOptions& options) {
    mesh.id = path.filename().string();
    mesh.flipNormals = options.flipNormals;
    if (mesh.indices.empty()) throw Error("{}: has no faces", path.string());
    for (const uint32_t index : mesh.indices)
        if (index >= mesh.positions.size())
            throw Error("{}: a face refers to vertex {} (counted from 0), but there are {}", path.string(),
                        index, mesh.positions.size());
    if (options.faceNormals || options.maxSmoothAngle) mesh.normals.clear();
    if (!options.toWorld.isIdentity())
        for (Vec3f& p : mesh.positions) p = options.toWorld.point(p);
    for (Vec3f& n : mesh.normals) n = normalize(options.toWorld.normal(n));
    if (options.toWorld.determinant3() < 0) keepOutside(mesh);
    if (options.maxSmoothAngle) {
        requireMemory(path, options, mesh.indices.size(), 2 * sizeof(Vec3f) + sizeof(Vec2f), "the mesh");
        splitAtSharpEdges(mesh, *options.maxSmoothAngle);
    }
    if (mesh.normals.empty() && !options.faceNormals) mesh.computeVertexNormals();
    if (options.toWorld.isSingular()) warnOfLostNormals(mesh, options);
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
