#include "base/error.h"
#include "io/mesh_io.h"
#include "io/ply_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <zlib.h>

namespace metrolux::core {

namespace {

namespace fs = std::filesystem;
using ply::Element;
using ply::Property;

/// A channel of an attribute by the end of its name: ("weight", 1) for "weight_y".
struct Channel {
    std::string base;
    int scheme = -1, index = 0;  // no scheme: the property stands alone
};

Channel channelOf(const std::string& name) {
    constexpr int kNumbers = 3;
    static const std::vector<std::string> kSchemes[] = {{"r", "g", "b", "a"},
                                                        {"red", "green", "blue", "alpha"},
                                                        {"x", "y", "z", "w"},
                                                        {"0", "1", "2", "3", "4"}};
    const size_t underscore = name.rfind('_');
    const bool hasPrefix = underscore != std::string::npos;
    const std::string suffix = hasPrefix ? name.substr(underscore + 1) : name;
    for (int scheme = 0; scheme <= (hasPrefix ? kNumbers : 1); ++scheme) {
        const auto& names = kSchemes[scheme];
        const auto it = std::find(names.begin(), names.end(), suffix);
        if (it == names.end()) continue;
        const bool isColor = scheme <= 1;
        const std::string base =
            !hasPrefix ? "color" : name.substr(0, underscore) + (isColor ? "_color" : "");
        return {base, scheme, static_cast<int>(it - names.begin())};
    }
    return {name, -1, 0};
}

/// Columns of an element that together are an attribute of the mesh.
struct AttributeColumns {
    TriangleMesh::Attribute attribute;
    std::vector<size_t> columns;
};

std::vector<AttributeColumns> findAttributes(const Element& element,
                                             const std::vector<std::string>& reserved) {
    std::vector<AttributeColumns> result;
    Channel last;
    for (size_t i = 0; i < element.properties.size(); ++i) {
        const Property& p = element.properties[i];
        if (p.countType || std::find(reserved.begin(), reserved.end(), p.name) != reserved.end()) {
            last = {};
            continue;
        }
        const Channel channel = channelOf(p.name);
        if (channel.scheme < 0 || channel.scheme != last.scheme || channel.base != last.base ||
            channel.index != last.index + 1) {
            result.emplace_back();
            result.back().attribute.name = element.name + "_" + channel.base;
        }
        result.back().columns.push_back(i);
        last = channel;
    }
    for (AttributeColumns& a : result) {
        // Attributes have one channel or three: a fourth is an opacity, the first of two stands for both.
        a.attribute.channels = a.columns.size() >= 3 ? 3 : 1;
        a.columns.resize(static_cast<size_t>(a.attribute.channels));
    }
    return result;
}

/// Integers are sRGB-encoded fractions of their maximum (Mitsuba's rule for attributes).
float attributeValue(ply::Type type, double value) {
    const double range = ply::integerRange(type);
    if (range == 0) return static_cast<float>(value);
    const double x = std::max(value / range, 0.0);
    return static_cast<float>(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
}

class Reader {
  public:
    Reader(const fs::path& path, const std::string& file, const MeshOptions& options)
        : path_(path),
          options_(options),
          header_(ply::parseHeader(path, file)),
          values_(path, std::string_view(file).substr(header_.size), header_.format) {}

    std::shared_ptr<TriangleMesh> read() {
        bool hasFaces = false;
        for (const Element& element : header_.elements) {
            values_.enter(element);
            if (element.name == "vertex") {
                readVertices(element);
            } else if (element.name == "face") {
                readFaces(element);
                hasFaces = true;
            } else if (!element.properties.empty()) {
                for (uint64_t i = 0; i < element.count; ++i) readRow(element, [](size_t, double) {});
            }
        }
        if (!hasFaces) throw Error("{}: has no element \"face\"", path_.string());
        for (const TriangleMesh::Attribute& a : mesh_->attributes)
            for (const float value : a.values)
                if (!std::isfinite(value))
                    throw Error("{}: attribute {} is not finite", path_.string(), a.name);
        finishMesh(*mesh_, path_, options_, exact_);
        return mesh_;
    }

  private:
    /// Calls column(index, value) for each scalar; lists are passed over.
    template <class Column>
    void readRow(const Element& element, Column&& column) {
        for (size_t i = 0; i < element.properties.size(); ++i) {
            const Property& p = element.properties[i];
            if (p.countType)
                for (uint64_t n = values_.listLength(p); n > 0; --n) values_.next(p.type);
            else
                column(i, values_.next(p.type));
        }
    }

    static void append(std::vector<AttributeColumns>& attributes, const Element& element,
                       const std::vector<double>& row) {
        for (AttributeColumns& a : attributes)
            for (const size_t c : a.columns)
                a.attribute.values.push_back(attributeValue(element.properties[c].type, row[c]));
    }

    static uint64_t attributeBytes(const std::vector<AttributeColumns>& attributes) {
        uint64_t values = 0;
        for (const AttributeColumns& a : attributes) values += a.columns.size();
        return values * sizeof(float);
    }

    void takeAttributes(std::vector<AttributeColumns>& attributes) {
        for (AttributeColumns& a : attributes) mesh_->attributes.push_back(std::move(a.attribute));
    }

    void readVertices(const Element& element) {
        const auto columns = [&](std::initializer_list<const char*> names) {
            std::vector<size_t> found;
            for (const char* name : names)
                if (const int i = element.find(name); i >= 0) found.push_back(static_cast<size_t>(i));
            return found.size() == names.size() ? found : std::vector<size_t>{};
        };
        const auto position = columns({"x", "y", "z"}), normal = columns({"nx", "ny", "nz"});
        if (position.empty()) throw Error("{}: element \"vertex\" has no x, y and z", path_.string());
        const auto uv = element.find("u") >= 0           ? columns({"u", "v"})
                        : element.find("texture_u") >= 0 ? columns({"texture_u", "texture_v"})
                                                         : columns({"s", "t"});
        const bool exact = options_.exact && element.properties[position[0]].type == ply::Type::Float64;
        std::vector<std::string> reserved;
        for (const auto* used : {&position, &normal, &uv})
            for (const size_t c : *used) reserved.push_back(element.properties[c].name);
        auto attributes = findAttributes(element, reserved);

        requireMemory(path_, options_, element.count,
                      (exact ? sizeof(Vec3f) + sizeof(Vec3d) : sizeof(Vec3f)) + attributeBytes(attributes),
                      "the vertices");
        mesh_->positions.reserve(element.count);
        std::vector<double> row(element.properties.size());
        const auto at = [&row](size_t c) { return static_cast<float>(row[c]); };
        for (uint64_t i = 0; i < element.count; ++i) {
            readRow(element, [&row](size_t c, double value) { row[c] = value; });
            mesh_->positions.emplace_back(at(position[0]), at(position[1]), at(position[2]));
            if (exact) exact_.emplace_back(row[position[0]], row[position[1]], row[position[2]]);
            if (!normal.empty()) mesh_->normals.emplace_back(at(normal[0]), at(normal[1]), at(normal[2]));
            if (!uv.empty()) mesh_->uvs.emplace_back(at(uv[0]), at(uv[1]));
            append(attributes, element, row);
        }
        takeAttributes(attributes);
    }

    void readFaces(const Element& element) {
        const auto isCorners = [](const Property& p) {
            return p.countType && (p.name == "vertex_index" || p.name == "vertex_indices");
        };
        if (std::none_of(element.properties.begin(), element.properties.end(), isCorners))
            throw Error("{}: element \"face\" has no list vertex_index or vertex_indices", path_.string());
        auto attributes = findAttributes(element, {});
        const uint64_t triangleBytes = 3 * sizeof(uint32_t) + attributeBytes(attributes);
        requireMemory(path_, options_, element.count, triangleBytes, "the faces");
        mesh_->indices.reserve(3 * element.count);
        std::vector<double> row(element.properties.size());
        std::vector<uint32_t> corners;
        size_t skipped = 0;
        for (uint64_t face = 0; face < element.count; ++face) {
            for (size_t i = 0; i < element.properties.size(); ++i) {
                const Property& p = element.properties[i];
                if (!p.countType) {
                    row[i] = values_.next(p.type);
                    continue;
                }
                const uint64_t length = values_.listLength(p);
                if (isCorners(p)) corners.clear();
                for (uint64_t n = 0; n < length; ++n) {
                    const double value = values_.next(p.type);
                    if (isCorners(p)) corners.push_back(cornerIndex(value, face));
                }
            }
            skipped += corners.size() < 3 ? 1 : 0;
            // Every triangle of a polygon has all attributes of the face: more than the file holds.
            requireMemory(path_, options_, mesh_->primitiveCount() + corners.size(), triangleBytes,
                          "the faces");
            for (size_t i = 2; i < corners.size(); ++i) {
                mesh_->indices.insert(mesh_->indices.end(), {corners[0], corners[i - 1], corners[i]});
                append(attributes, element, row);
            }
        }
        if (skipped > 0)
            warn(options_, fmt::format("{}: faces of less than three vertices are left out ({})",
                                       path_.string(), skipped));
        takeAttributes(attributes);
    }

    uint32_t cornerIndex(double value, uint64_t face) const {
        if (!(value >= 0 && value < 4294967295.0) || value != std::floor(value))
            throw Error("{}: face {} refers to vertex {}", path_.string(), face, value);
        return static_cast<uint32_t>(value);
    }

    const fs::path& path_;
    const MeshOptions& options_;
    ply::Header header_;
    ply::Values values_;
    std::shared_ptr<TriangleMesh> mesh_ = std::make_shared<TriangleMesh>();
    std::vector<Vec3d> exact_;  ///< MeshOptions::exact
};

}  // namespace

bool plyHasNormals(const fs::path& path) {
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
    if (!file) throw Error("{}: cannot be opened for reading", path.string());
    constexpr size_t kMost = size_t{1} << 20;
    std::string header;
    char piece[4096];
    while (header.size() < kMost && header.find("end_header") == std::string::npos) {
        const int count = gzread(file.get(), piece, sizeof piece);
        if (count <= 0) break;  // readPly() says what is wrong
        header.append(piece, static_cast<size_t>(count));
    }
    return header.substr(0, header.find("end_header")).find(" nx") != std::string::npos;
}

std::shared_ptr<TriangleMesh> readPly(const fs::path& path, const MeshOptions& options) {
    const std::string file = readMeshFile(path, options);
    return Reader(path, file, options).read();
}

}  // namespace metrolux::core
