#include "io/mesh_io.h"

#include "base/error.h"
#include "io/mesh_smoothing.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <memory>
#include <zlib.h>

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

namespace {

/// What a file compressed by gzip holds, all its members.
std::string inflated(const std::filesystem::path& path, const std::string& compressed,
                     const MeshOptions& options) {
    constexpr size_t kStep = size_t{1} << 20;
    constexpr int kGzip = 16 + MAX_WBITS;
    z_stream stream{};
    if (inflateInit2(&stream, kGzip) != Z_OK) throw Error("{}: zlib cannot start", path.string());
    const std::unique_ptr<z_stream, int (*)(z_stream*)> ended(&stream, inflateEnd);
    std::string result;
    const auto* const bytes = reinterpret_cast<const Bytef*>(compressed.data());
    size_t read = 0, written = 0;
    int status = Z_OK;
    while (read < compressed.size() || stream.avail_out == 0) {
        if (status == Z_STREAM_END && inflateReset(&stream) != Z_OK) break;
        requireMemory(path, options, written + kStep, 1, "the file");
        result.resize(written + kStep);
        stream.next_in = const_cast<Bytef*>(bytes + read);
        stream.avail_in = static_cast<uInt>(std::min(compressed.size() - read, kStep));
        stream.next_out = reinterpret_cast<Bytef*>(result.data() + written);
        stream.avail_out = static_cast<uInt>(kStep);
        status = inflate(&stream, Z_NO_FLUSH);
        read = static_cast<size_t>(stream.next_in - bytes);
        written += kStep - stream.avail_out;
        if (status != Z_OK && status != Z_STREAM_END) break;
        if (status == Z_STREAM_END && read == compressed.size()) break;
    }
    if (status != Z_STREAM_END)
        throw Error("{}: is damaged: found no end of its compressed data (gzip)", path.string());
    result.resize(written);
    return result;
}

}  // namespace

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
    if (text.starts_with("\x1f\x8b")) text = inflated(path, text, options);
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

/// A mesh whose triangles are not much larger than the steps of single precision where they are.
void warnOfLostDetail(const TriangleMesh& mesh, const MeshOptions& options, const char* where) {
    Vec3f lower, upper;
    mesh.bounds(lower, upper);
    const Vec3f center = (lower + upper) * 0.5f;
    if (!(center.length() > 32 * (upper - lower).length())) return;
    float largest = 0;
    for (int i = 0; i < 3; ++i) largest = std::max({largest, std::abs(lower[i]), std::abs(upper[i])});
    const double step = std::nextafter(largest, kInfinity) - largest;
    double area = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const Vec3d p(mesh.positions[mesh.indices[i]]);
        area += 0.5 * (Vec3d(mesh.positions[mesh.indices[i + 1]]) - p)
                          .cross(Vec3d(mesh.positions[mesh.indices[i + 2]]) - p)
                          .length();
    }
    const double side = std::sqrt(2 * area / double(mesh.primitiveCount()));
    if (step * 64 < side) return;
    warn(options, fmt::format("detail is lost: {} single precision has steps of {:.2g} at ({:.6g}, {:.6g}, "
                              "{:.6g}), where its triangles have sides of about {:.2g}",
                              where, step, center.x, center.y, center.z, side));
}

}  // namespace

void finishMesh(TriangleMesh& mesh, const std::filesystem::path& path, const MeshOptions& options,
                const std::vector<Vec3d>& exact) {
    mesh.id = path.filename().string();
    mesh.flipNormals = options.flipNormals;
    if (mesh.indices.empty()) throw Error("{}: has no faces", path.string());
    for (const uint32_t index : mesh.indices)
        if (index >= mesh.positions.size())
            throw Error("{}: a face refers to vertex {} (counted from 0), but there are {}", path.string(),
                        index, mesh.positions.size());
    if (options.faceNormals || options.maxSmoothAngle) mesh.normals.clear();
    if (exact.empty()) warnOfLostDetail(mesh, options, "in the mesh's own coordinates");
    for (size_t i = 0; i < exact.size(); ++i) mesh.positions[i] = Vec3f(options.toWorld.exactPoint(exact[i]));
    if (exact.empty() && !options.toWorld.isIdentity())
        for (Vec3f& p : mesh.positions) p = options.toWorld.point(p);
    if (!options.toWorld.isSingular()) warnOfLostDetail(mesh, options, "in the world");
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
