#include "base/error.h"
#include "io/mesh_io.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <istream>
#include <streambuf>
#include <string_view>
#include <tiny_obj_loader.h>
#include <unordered_map>

namespace metrolux::core {

namespace {

namespace fs = std::filesystem;

/// The next word of a line, which is shortened by it; empty at the end or at a comment.
std::string_view nextWord(std::string_view& line) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    if (line.starts_with('#')) return {};
    const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
    line.remove_prefix(word.size());
    return word;
}

/// v, v/vt, v//vn or v/vt/vn, each a number that fits into 32 bits.
bool isCorner(std::string_view word) {
    if (std::count(word.begin(), word.end(), '/') > 2) return false;
    int digits = 0;
    for (const char c : word) {
        digits = c >= '0' && c <= '9' ? digits + 1 : 0;
        if (digits > 9 || !(digits > 0 || c == '-' || c == '/')) return false;
    }
    return true;
}

/// Stands for a space in the name of a material, at which tinyobjloader would end it.
constexpr char kSpaceInName = '\x1f';

/// A backslash at the end of a line, other than a comment, joins it with the next one. Returns the end of the
/// whole line from `begin`; `lines` counts the lines that were joined.
size_t joinLines(std::string& text, size_t begin, size_t& lines) {
    size_t end = std::min(text.find('\n', begin), text.size());
    if (const size_t first = text.find_first_not_of(" \t", begin); first < end && text[first] == '#')
        return end;
    while (end < text.size()) {
        const size_t last = text.find_last_not_of(" \t\r", end - 1);
        if (end == begin || last == std::string::npos || last < begin || text[last] != '\\') break;
        std::fill(text.begin() + static_cast<std::ptrdiff_t>(last),
                  text.begin() + static_cast<std::ptrdiff_t>(end + 1), ' ');
        ++lines;
        end = std::min(text.find('\n', end), text.size());
    }
    return end;
}

/// Zero for what is none, as tinyobjloader has it.
double numberOf(std::string_view word) {
    double value = 0;
    if (word.starts_with('+')) word.remove_prefix(1);
    std::from_chars(word.data(), word.data() + word.size(), value);
    return value;
}

/// tinyobjloader reads what is no number as zero, and a missing coordinate too: such lines are refused here.
/// Comments after faces, which it takes for further vertices, are blanked, and so are faces of less than
/// three vertices: their number is returned. `exact`, if given, receives the positions, which tinyobjloader
/// rounds.
size_t checkLines(const fs::path& path, std::string& text, std::vector<Vec3d>* exact) {
    size_t lineNumber = 0, skipped = 0;
    const auto blank = [&text](size_t from, size_t to) {
        std::fill(text.begin() + static_cast<std::ptrdiff_t>(from),
                  text.begin() + static_cast<std::ptrdiff_t>(to), ' ');
    };
    for (size_t begin = 0; begin < text.size();) {
        ++lineNumber;
        size_t joined = 0;
        const size_t end = joinLines(text, begin, joined);
        std::string_view line(text.data() + begin, end - begin);
        const std::string_view keyword = nextWord(line);
        const bool face = keyword == "f";
        const size_t expected = keyword == "v" || keyword == "vn" || face ? 3 : keyword == "vt" ? 2 : 0;
        size_t count = 0;
        Vec3d position(0.0);
        // What follows the coordinates, weights and colors, is not used.
        for (; expected > 0 && (face || count < expected); ++count) {
            const std::string_view word = nextWord(line);
            if (word.empty()) break;
            if (face ? !isCorner(word) : word.find_first_not_of("0123456789+-.eE") != std::string_view::npos)
                throw Error("{}:{}: \"{}\" is not {}", path.string(), lineNumber, word,
                            face ? "a vertex of a face (v, v/vt, v//vn or v/vt/vn)" : "a number");
            if (exact && keyword == "v") position[static_cast<int>(count)] = numberOf(word);
        }
        if (exact && keyword == "v") exact->push_back(position);
        if (face && count < expected) {
            blank(begin, end);
            ++skipped;
        } else if (count < expected) {
            throw Error("{}:{}: \"{}\" with {} values, expected {}", path.string(), lineNumber, keyword,
                        count, expected);
        } else if (face) {
            blank(end - line.size(), end);
        } else if (keyword == "usemtl") {
            const size_t first = text.find_first_not_of(" \t", end - line.size());
            const size_t last = text.find_last_not_of(" \t\r", end - 1);
            for (size_t i = first; i < last; ++i)
                if (text[i] == ' ' || text[i] == '\t') text[i] = kSpaceInName;
        }
        lineNumber += joined;
        begin = end + 1;
    }
    return skipped;
}

/// Collects what the parser reports; exceptions must not cross the library, so that the first error waits
/// here.
class Builder {
  public:
    explicit Builder(const MeshOptions& options) : options_(options) {}

    /// Of the positions that follow; empty where single precision does.
    std::vector<Vec3d>& exactPositions() { return exactPositions_; }

    void addVertex(float x, float y, float z) {
        positions_.emplace_back(x, y, z);
        firstOfPosition_.push_back(kNone);
    }
    void addNormal(float x, float y, float z) { normals_.emplace_back(x, y, z); }
    void addTexCoord(float u, float v) { texCoords_.emplace_back(u, v); }
    void useMaterial(std::string name) {
        std::replace(name.begin(), name.end(), kSpaceInName, ' ');
        const auto [entry, isNew] = materialIds_.emplace(name, static_cast<uint32_t>(materials_.size()));
        material_ = entry->second;
        if (isNew) materials_.push_back(std::move(name));
    }

    void addFace(const tinyobj::index_t* corners, int count) {
        ++faces_;
        checkMemory(static_cast<uint64_t>(count));
        std::array<uint32_t, 3> triangle{};
        for (int i = 0; i < count && error_.empty(); ++i) {
            const uint32_t vertex = vertexOf(corners[i]);
            if (i < 3) {
                triangle[static_cast<size_t>(i)] = vertex;
            } else {
                triangle[1] = triangle[2];
                triangle[2] = vertex;
            }
            if (i < 2) continue;
            mesh_->indices.insert(mesh_->indices.end(), triangle.begin(), triangle.end());
            materialOfTriangle_.push_back(material_);
        }
    }

    std::shared_ptr<TriangleMesh> finish(const fs::path& path) {
        complete(path);
        finishMesh(*mesh_, path, options_, exact_);
        return mesh_;
    }

    std::vector<MaterialPart> finishByMaterial(const fs::path& path) {
        complete(path);
        std::vector<std::vector<size_t>> triangles(materials_.size());
        for (size_t i = 0; i < materialOfTriangle_.size(); ++i)
            triangles[materialOfTriangle_[i]].push_back(i);
        std::vector<MaterialPart> result;
        for (size_t material = 0; material < materials_.size(); ++material) {
            if (triangles[material].empty()) continue;
            std::vector<Vec3d> exact;
            MaterialPart part{materials_[material], partOf(triangles[material], exact)};
            finishMesh(*part.mesh, path, options_, exact);
            result.push_back(std::move(part));
        }
        if (result.empty()) throw Error("{}: has no faces", path.string());
        return result;
    }

  private:
    static constexpr uint32_t kNone = ~0u;

    void complete(const fs::path& path) {
        if (!error_.empty()) throw Error("{}: {}", path.string(), error_);
        if (normals_.empty()) mesh_->normals.clear();
        if (texCoords_.empty()) mesh_->uvs.clear();
        if (exact_.size() != mesh_->positions.size()) exact_.clear();
    }

    /// Some of the triangles with the vertices that they need.
    std::shared_ptr<TriangleMesh> partOf(const std::vector<size_t>& triangles,
                                         std::vector<Vec3d>& exact) const {
        auto part = std::make_shared<TriangleMesh>();
        std::unordered_map<uint32_t, uint32_t> moved;
        for (size_t i = 0; i < 3 * triangles.size(); ++i) {
            const uint32_t from = mesh_->indices[3 * triangles[i / 3] + i % 3];
            const auto [entry, isNew] = moved.emplace(from, static_cast<uint32_t>(moved.size()));
            if (isNew) {
                part->positions.push_back(mesh_->positions[from]);
                if (!exact_.empty()) exact.push_back(exact_[from]);
                if (!mesh_->normals.empty()) part->normals.push_back(mesh_->normals[from]);
                if (!mesh_->uvs.empty()) part->uvs.push_back(mesh_->uvs[from]);
            }
            part->indices.push_back(entry->second);
        }
        return part;
    }

    /// A combination of indices that has become a vertex of the mesh; those of one position form a list.
    struct Corner {
        int64_t texCoord, normal;
        uint32_t vertex, next;
    };

    /// Vertices of the mesh are combinations of the file's: there can be far more of them.
    void checkMemory(uint64_t newCorners) {
        if (!options_.memory || !error_.empty()) return;
        constexpr uint64_t kCornerBytes = sizeof(Corner) + 2 * sizeof(Vec3f) + sizeof(Vec2f);
        const uint64_t corners = corners_.size() + newCorners;
        const uint64_t indices = mesh_->indices.size() + 3 * newCorners;
        try {
            options_.memory->require(corners * kCornerBytes + indices * sizeof(uint32_t), "the mesh");
        } catch (const Error& error) {
            error_ = error.what();
        }
    }

    /// Index from 0, or -1 for one that the face does not have. Negative indices count from the end.
    int64_t resolve(int index, size_t count, const char* what) {
        if (index == 0) return -1;
        const int64_t resolved = index > 0 ? int64_t(index) - 1 : static_cast<int64_t>(count) + index;
        if (resolved < 0 || resolved >= static_cast<int64_t>(count)) {
            error_ = fmt::format("face {} refers to {} {}, but there are {}", faces_, what, index, count);
            return -1;
        }
        return resolved;
    }

    uint32_t vertexOf(const tinyobj::index_t& corner) {
        const int64_t position = resolve(corner.vertex_index, positions_.size(), "vertex");
        const int64_t texCoord = resolve(corner.texcoord_index, texCoords_.size(), "texture coordinate");
        const int64_t normal = resolve(corner.normal_index, normals_.size(), "normal");
        if (position < 0 && error_.empty())
            error_ = fmt::format("face {} has a vertex without a position", faces_);
        if (!error_.empty()) return 0;
        uint32_t& first = firstOfPosition_[static_cast<size_t>(position)];
        for (uint32_t i = first; i != kNone; i = corners_[i].next)
            if (corners_[i].texCoord == texCoord && corners_[i].normal == normal) return corners_[i].vertex;
        const auto vertex = static_cast<uint32_t>(mesh_->positions.size());
        corners_.push_back({texCoord, normal, vertex, first});
        first = static_cast<uint32_t>(corners_.size() - 1);
        mesh_->positions.push_back(positions_[static_cast<size_t>(position)]);
        if (static_cast<size_t>(position) < exactPositions_.size())
            exact_.push_back(exactPositions_[static_cast<size_t>(position)]);
        // A zero normal makes the mesh fall back on the geometric one.
        mesh_->normals.push_back(normal < 0 ? Vec3f(0.0f) : normals_[static_cast<size_t>(normal)]);
        mesh_->uvs.push_back(texCoord < 0 ? Vec2f(0.0f) : texCoords_[static_cast<size_t>(texCoord)]);
        return vertex;
    }

    const MeshOptions& options_;
    std::shared_ptr<TriangleMesh> mesh_ = std::make_shared<TriangleMesh>();
    std::vector<Vec3f> positions_, normals_;
    std::vector<Vec3d> exactPositions_, exact_;  ///< of the file's and of the mesh's vertices
    std::vector<Vec2f> texCoords_;
    std::vector<Corner> corners_;
    std::vector<uint32_t> firstOfPosition_;
    std::vector<std::string> materials_ = {""};
    std::unordered_map<std::string, uint32_t> materialIds_ = {{"", 0}};
    std::vector<uint32_t> materialOfTriangle_;
    uint32_t material_ = 0;
    size_t faces_ = 0;
    std::string error_;
};

struct MemoryBuffer : std::streambuf {
    explicit MemoryBuffer(std::string& text) { setg(text.data(), text.data(), text.data() + text.size()); }
};

void parse(const fs::path& path, const MeshOptions& options, Builder& builder) {
    std::string text = readMeshFile(path, options);
    if (const size_t skipped = checkLines(path, text, options.exact ? &builder.exactPositions() : nullptr))
        warn(options,
             fmt::format("{}: faces of less than three vertices are left out ({})", path.string(), skipped));
    tinyobj::callback_t callbacks;
    callbacks.usemtl_cb = [](void* b, const char* name, int) { static_cast<Builder*>(b)->useMaterial(name); };
    callbacks.vertex_cb = [](void* b, float x, float y, float z, float) {
        static_cast<Builder*>(b)->addVertex(x, y, z);
    };
    callbacks.normal_cb = [](void* b, float x, float y, float z) {
        static_cast<Builder*>(b)->addNormal(x, y, z);
    };
    callbacks.texcoord_cb = [](void* b, float u, float v, float) {
        static_cast<Builder*>(b)->addTexCoord(u, v);
    };
    callbacks.index_cb = [](void* b, tinyobj::index_t* corners, int count) {
        static_cast<Builder*>(b)->addFace(corners, count);
    };
    MemoryBuffer buffer(text);
    std::istream stream(&buffer);
    std::string warning, error;
    if (!tinyobj::LoadObjWithCallback(stream, callbacks, &builder, nullptr, &warning, &error))
        throw Error("{}: {}", path.string(), error);
}

}  // namespace

std::shared_ptr<TriangleMesh> readObj(const fs::path& path, const MeshOptions& options) {
    Builder builder(options);
    parse(path, options, builder);
    return builder.finish(path);
}

std::vector<MaterialPart> readObjByMaterial(const fs::path& path, const MeshOptions& options) {
    Builder builder(options);
    parse(path, options, builder);
    return builder.finishByMaterial(path);
}

}  // namespace metrolux::core
