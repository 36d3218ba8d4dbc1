#pragma once
/// Readers of mesh files. All of them check what a file declares against its size before they allocate, and
/// throw Error with the file's name, what was found and what was expected.

#include "base/memory_budget.h"
#include "base/transform.h"
#include "geometry/shape.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace metrolux::core {

struct MeshOptions {
    Transform toWorld;
    bool flipNormals = false;  ///< turn the surface inside out
    bool faceNormals =
        false;  ///< drop the file's vertex normals; without, they are computed where the file has none
    bool flipTexCoords = false;  ///< v becomes 1 - v
    bool exact = false;          ///< positions keep what the file has beyond single precision up to toWorld
    /// Drop the file's vertex normals, and compute new ones that are smooth across edges up to this angle
    /// between their faces, in degrees.
    std::optional<float> maxSmoothAngle;
    std::vector<std::string>* warnings =
        nullptr;                     ///< what was let pass, without the file's name; may be null
    MemoryBudget* memory = nullptr;  ///< what the mesh is booked on; null: no bound
};

/// Wavefront OBJ: all faces of the file as one mesh, polygons as triangle fans. Groups and materials are
/// ignored. Faces of less than three vertices are left out with a warning.
std::shared_ptr<TriangleMesh> readObj(const std::filesystem::path& path, const MeshOptions& options);

/// The faces that a file puts under one name of a material.
struct MaterialPart {
    std::string material;  ///< empty: before any `usemtl`
    std::shared_ptr<TriangleMesh> mesh;
};
/// The same, a mesh for each material in the order of their first faces.
std::vector<MaterialPart> readObjByMaterial(const std::filesystem::path& path, const MeshOptions& options);

/// PLY, ascii or binary of either byte order. Further properties of vertices and faces become attributes with
/// Mitsuba's names: consecutive `weight_0, weight_1, weight_2` (or _x _y _z, _1 _2 _3) are "vertex_weight"
/// with three channels, `albedo_r, albedo_g, albedo_b` are "vertex_albedo_color", `r, g, b` or `red, green,
/// blue` are "vertex_color". Integers are sRGB-encoded fractions of their maximum. Faces of less than three
/// vertices are left out with a warning.
std::shared_ptr<TriangleMesh> readPly(const std::filesystem::path& path, const MeshOptions& options);
/// Whether a PLY, which may be compressed by gzip, names normals in its header; what follows is not read.
bool plyHasNormals(const std::filesystem::path& path);

/// One mesh of Mitsuba's compressed format, versions 3 and 4.
std::shared_ptr<TriangleMesh> readSerialized(const std::filesystem::path& path, int shapeIndex,
                                             const MeshOptions& options);

// What the readers share.

/// The whole file, if there is memory for it, without a byte order mark and decompressed if it is a gzip
/// file.
std::string readMeshFile(const std::filesystem::path& path, const MeshOptions& options);
/// Throws Error unless `count` of `what`, of so many bytes each, fit the memory that is left.
void requireMemory(const std::filesystem::path& path, const MeshOptions& options, uint64_t count,
                   uint64_t bytesEach, std::string_view what);

/// Notes a warning where the caller wants to know.
void warn(const MeshOptions& options, const std::string& message);

/// Takes a mesh in object space to the world, settles its normals and finalizes it. `exact`: its positions
/// in double precision, or empty. Warns where single precision loses its shape.
void finishMesh(TriangleMesh& mesh, const std::filesystem::path& path, const MeshOptions& options,
                const std::vector<Vec3d>& exact = {});

}  // namespace metrolux::core
