// Mitsuba's serialized meshes: each mesh is a header of 4 bytes and a zlib stream, the file ends with a table
// of offsets.
#include "base/error.h"
#include "io/mesh_io.h"

#include <bit>
#include <cstring>
#include <zlib.h>

namespace metrolux::core {

namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "the format is little-endian");

enum Flags : uint32_t {
    kHasNormals = 0x1,
    kHasTexCoords = 0x2,
    kHasColors = 0x8,
    kFaceNormals = 0x10,
    kDoublePrecision = 0x2000,  // single without it, whether or not 0x1000 says so
};

constexpr uint16_t kMagic = 0x041C;
/// DEFLATE cannot expand by more than this (zlib's technical notes: 1032 to 1).
constexpr uint64_t kMaxExpansion = 1032;
constexpr size_t kLongestName = 4096;

template <class T>
T readAt(const fs::path& path, const std::string& file, uint64_t offset) {
    if (offset > file.size() || file.size() - offset < sizeof(T))
        throw Error("{}: truncated: {} bytes expected at offset {}, the file has {}", path.string(),
                    sizeof(T), offset, file.size());
    T value;
    std::memcpy(&value, file.data() + offset, sizeof(T));
    return value;
}

class Inflater {
  public:
    Inflater(const fs::path& path, const std::string& file, uint64_t offset) : path_(path) {
        // More input than 4 GB is handed over in the order in which it is consumed.
        next_ = file.data() + offset;
        left_ = file.size() - offset;
        capacity_ = left_ * kMaxExpansion;
        if (inflateInit(&stream_) != Z_OK) throw Error("{}: zlib cannot start", path_.string());
    }
    ~Inflater() { inflateEnd(&stream_); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    void read(void* target, size_t size) {
        constexpr size_t kPiece = size_t(1) << 30;
        auto* out = static_cast<Bytef*>(target);
        while (size > 0) {
            if (stream_.avail_in == 0 && left_ > 0) {
                stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(next_));
                stream_.avail_in = static_cast<uInt>(std::min(left_, kPiece));
                next_ += stream_.avail_in;
                left_ -= stream_.avail_in;
            }
            const size_t piece = std::min(size, kPiece);
            stream_.next_out = out;
            stream_.avail_out = static_cast<uInt>(piece);
            const int status = inflate(&stream_, Z_NO_FLUSH);
            const size_t done = piece - stream_.avail_out;
            out += done;
            size -= done;
            if (status != Z_OK && size > 0)
                throw Error("{}: {}: {} more bytes expected", path_.string(),
                            status == Z_DATA_ERROR ? "the compressed data are damaged" : "truncated", size);
        }
    }

    template <class T>
    T read() {
        T value;
        read(&value, sizeof(T));
        return value;
    }

    /// A text that ends with a zero. No program writes long ones, and it is read byte by byte.
    void skipName() {
        for (size_t length = 0; read<char>() != '\0'; ++length)
            if (length == kLongestName)
                throw Error("{}: the mesh's name has more than {} bytes", path_.string(), kLongestName);
    }

    /// Refuses counts that the compressed data cannot hold, before memory is allocated for them.
    void expect(uint64_t count, uint64_t bytesEach, const char* what) const {
        if (count > capacity_ / bytesEach)
            throw Error("{}: declares {} {}, more than its size allows", path_.string(), count, what);
    }

    /// `count` vectors of Dim numbers in either precision.
    template <class Vec, int Dim>
    std::vector<Vec> vectors(size_t count, bool doublePrecision) {
        static_assert(sizeof(Vec) == Dim * sizeof(float));
        std::vector<Vec> result(count);
        if (!doublePrecision) {
            read(result.data(), count * sizeof(Vec));
            return result;
        }
        double row[Dim];
        for (Vec& v : result) {
            read(row, sizeof(row));
            for (int i = 0; i < Dim; ++i) v[i] = static_cast<float>(row[i]);
        }
        return result;
    }

  private:
    const fs::path& path_;
    z_stream stream_{};
    const char* next_ = nullptr;
    size_t left_ = 0;
    uint64_t capacity_ = 0;
};

uint64_t offsetOfMesh(const fs::path& path, const std::string& file, uint16_t version, int shapeIndex) {
    if (shapeIndex == 0) return 0;
    const uint64_t tableEnd = file.size() - sizeof(uint32_t);  // the header is longer than that
    const auto count = readAt<uint32_t>(path, file, tableEnd);
    if (shapeIndex < 0 || static_cast<uint32_t>(shapeIndex) >= count)
        throw Error("{}: shape_index {} is out of range, the file declares {} meshes", path.string(),
                    shapeIndex, count);
    const uint64_t entrySize = version == 3 ? sizeof(uint32_t) : sizeof(uint64_t);
    const uint64_t back = (count - static_cast<uint32_t>(shapeIndex)) * entrySize;
    if (back > tableEnd)
        throw Error("{}: the table of {} meshes is longer than the file", path.string(), count);
    return version == 3 ? readAt<uint32_t>(path, file, tableEnd - back)
                        : readAt<uint64_t>(path, file, tableEnd - back);
}

}  // namespace

std::shared_ptr<TriangleMesh> readSerialized(const fs::path& path, int shapeIndex,
                                             const MeshOptions& options) {
    const std::string file = readMeshFile(path, options);
    const auto magic = readAt<uint16_t>(path, file, 0);
    const auto version = readAt<uint16_t>(path, file, 2);
    if (magic != kMagic)
        throw Error("{}: not a serialized mesh (begins with {:#06x}, expected {:#06x})", path.string(), magic,
                    kMagic);
    if (version != 3 && version != 4)
        throw Error("{}: version {} of the format, expected 3 or 4", path.string(), version);
    const uint64_t offset = offsetOfMesh(path, file, version, shapeIndex);
    if (readAt<uint16_t>(path, file, offset) != kMagic)
        throw Error("{}: no mesh at offset {}, to which the table points", path.string(), offset);
    readAt<uint16_t>(path, file, offset + 2);

    Inflater in(path, file, offset + 4);
    const auto flags = in.read<uint32_t>();
    if (version == 4) in.skipName();
    const auto vertexCount = in.read<uint64_t>(), faceCount = in.read<uint64_t>();
    const bool doublePrecision = (flags & kDoublePrecision) != 0;
    if (vertexCount > 0xFFFFFFFFu)
        throw Error("{}: {} vertices, at most 2^32-1 are supported", path.string(), vertexCount);
    in.expect(vertexCount, doublePrecision ? 24 : 12, "vertices");
    in.expect(faceCount, 12, "faces");

    const bool colored = (flags & kHasColors) != 0;
    requireMemory(path, options, vertexCount, colored ? 48 : 36, "the vertices");
    requireMemory(path, options, faceCount, 12, "the faces");

    auto mesh = std::make_shared<TriangleMesh>();
    std::vector<Vec3d> exact;
    if (doublePrecision && options.exact) {
        requireMemory(path, options, vertexCount, sizeof(Vec3d), "the vertices");
        exact.resize(vertexCount);
        in.read(exact.data(), vertexCount * sizeof(Vec3d));
        for (const Vec3d& p : exact) mesh->positions.emplace_back(p);
    } else {
        mesh->positions = in.vectors<Vec3f, 3>(vertexCount, doublePrecision);
    }
    if (flags & kHasNormals) mesh->normals = in.vectors<Vec3f, 3>(vertexCount, doublePrecision);
    if (flags & kHasTexCoords) mesh->uvs = in.vectors<Vec2f, 2>(vertexCount, doublePrecision);
    if (flags & kHasColors) {
        TriangleMesh::Attribute colors{"vertex_color", 3, {}};
        for (const Rgb& c : in.vectors<Rgb, 3>(vertexCount, doublePrecision))
            colors.values.insert(colors.values.end(), {c.x, c.y, c.z});
        mesh->attributes.push_back(std::move(colors));
    }
    mesh->indices.resize(faceCount * 3);
    in.read(mesh->indices.data(), mesh->indices.size() * sizeof(uint32_t));

    MeshOptions effective = options;
    if (flags & kFaceNormals) effective.faceNormals = true;
    finishMesh(*mesh, path, effective, exact);
    return mesh;
}

}  // namespace metrolux::core
