#include "io/mitsuba/xml_writer.h"

#include "base/error.h"
#include "image/atomic_file.h"
#include "image/image_io.h"

#include <algorithm>

namespace metrolux::core::mitsuba {
namespace {

namespace fs = std::filesystem;

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        const char* replaced = c == '&'   ? "&amp;"
                               : c == '<' ? "&lt;"
                               : c == '>' ? "&gt;"
                               : c == '"' ? "&quot;"
                                          : nullptr;
        if (c == '$') replaced = "\\$";  // no parameter
        if (replaced)
            result.append(replaced);
        else
            result.push_back(c);
    }
    return result;
}

/// The shortest text that is read as the same number.
std::string text(double value) { return fmt::format("{}", value); }

template <class T>
void append(std::string& bytes, const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Names of the columns that are read as this attribute (readPly).
std::vector<std::string> columnsOf(const std::string& name, int channels) {
    const std::string base = name.substr(name.find('_') + 1);
    if (channels == 1) return {base};
    if (base == "color") return {"r", "g", "b"};
    return {base + "_0", base + "_1", base + "_2"};
}

std::string plyOf(const MeshArrays& mesh) {
    const size_t vertices = mesh.positions.size() / 3, faces = mesh.triangles.size() / 3;
    std::string header = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", vertices);
    const auto properties = [&](std::initializer_list<const char*> names) {
        for (const char* name : names) header += fmt::format("property float {}\n", name);
    };
    const auto attributesOf = [&](const char* prefix) {
        std::vector<const MeshArrays::Attribute*> result;
        for (const MeshArrays::Attribute& a : mesh.attributes) {
            if (!a.name.starts_with(prefix)) continue;
            result.push_back(&a);
            for (const std::string& column : columnsOf(a.name, a.channels))
                header += fmt::format("property float {}\n", column);
        }
        return result;
    };
    properties({"x", "y", "z"});
    if (!mesh.normals.empty()) properties({"nx", "ny", "nz"});
    if (!mesh.uvs.empty()) properties({"u", "v"});
    const auto ofVertices = attributesOf("vertex_");
    header += fmt::format("element face {}\nproperty list uchar uint vertex_indices\n", faces);
    const auto ofFaces = attributesOf("face_");
    std::string bytes = header + "end_header\n";
    const auto row = [&](std::span<const float> values, size_t width, size_t i) {
        for (size_t c = 0; c < width; ++c) append(bytes, values[i * width + c]);
    };
    for (size_t v = 0; v < vertices; ++v) {
        row(mesh.positions, 3, v);
        if (!mesh.normals.empty()) row(mesh.normals, 3, v);
        if (!mesh.uvs.empty()) row(mesh.uvs, 2, v);
        for (const auto* a : ofVertices) row(a->values, static_cast<size_t>(a->channels), v);
    }
    for (size_t f = 0; f < faces; ++f) {
        append(bytes, uint8_t{3});
        for (size_t k = 0; k < 3; ++k) append(bytes, mesh.triangles[3 * f + k]);
        for (const auto* a : ofFaces) row(a->values, static_cast<size_t>(a->channels), f);
    }
    return bytes;
}

/// Colors or one channel; textures do not show opacities.
std::string exrOf(const PixelArray& pixels) {
    const int channels = pixels.channels >= 3 ? 3 : 1;
    ImageData image{pixels.width, pixels.height, channels, {}};
    for (size_t i = 0; i < pixels.pixels.size(); i += static_cast<size_t>(pixels.channels))
        image.pixels.insert(image.pixels.end(), pixels.pixels.begin() + static_cast<std::ptrdiff_t>(i),
                            pixels.pixels.begin() + static_cast<std::ptrdiff_t>(i) + channels);
    return encodeExr(image);
}

std::string volOf(const VoxelArray& voxels) {
    constexpr uint8_t kVersion = 3;
    constexpr int32_t kFloats = 1;
    std::string bytes = "VOL";
    append(bytes, kVersion);
    append(bytes, kFloats);
    for (const int n : voxels.resolution) append(bytes, static_cast<int32_t>(n));
    append(bytes, static_cast<int32_t>(voxels.channels));
    for (const float bound : {0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f}) append(bytes, bound);
    for (const float value : voxels.values) append(bytes, value);
    return bytes;
}

/// What keeps the arrays of a value, null for other values.
struct OwnerOf {
    template <class T>
    const void* operator()(const T& value) const {
        if constexpr (requires { value.owner; })
            return value.owner.get();
        else
            return nullptr;
    }
};

class Writer {
  public:
    Writer(const ParsedScene& scene, const fs::path& file)
        : scene_(scene), file_(file), folder_(file.stem().string() + "_files") {
        for (const Property* property : contentsOf(*scene.root))
            if (const ElementPtr* child = std::get_if<ElementPtr>(&property->value); child && *child)
                top_.insert(child->get());
        announce(*scene.root);
    }

    std::vector<fs::path> run() {
        std::string xml = "<scene version=\"3.0.0\">\n";
        contents(*scene_.root, xml, 1);
        xml += "</scene>\n";
        std::vector<fs::path> written;
        if (!files_.empty()) fs::create_directories(file_.parent_path() / folder_);
        for (const auto& [name, bytes] : files_) {
            written.push_back(file_.parent_path() / folder_ / name);
            writeFile(written.back(), bytes);
        }
        written.push_back(file_);
        writeFile(file_, xml);
        return written;
    }

  private:
    struct Named {
        const std::string* name;
        const Property* property;
    };

    /// All that an element contains, in its order.
    static std::vector<const Property*> contentsOf(const Element& element) {
        std::vector<const Property*> result;
        for (const auto& entry : element.named) result.push_back(&entry.second);
        for (const Property& property : element.children) result.push_back(&property);
        std::stable_sort(result.begin(), result.end(),
                         [](const Property* a, const Property* b) { return a->order < b->order; });
        return result;
    }
    static std::string nameOf(const Element& element, const Property& property) {
        for (const auto& [name, candidate] : element.named)
            if (&candidate == &property) return name;
        return {};
    }

    /// Notes ids and which elements occur several times; refuses what cannot be converted.
    void announce(const Element& element) {
        if (element.isLegacy())
            throw element.error("of a scene of 0.x, whose plugins and rules are not those of Mitsuba 3");
        if (!element.id.empty()) ids_.insert(element.id);
        if (++occurrences_[&element] > 1) return;
        for (const Property* property : contentsOf(element))
            if (const ElementPtr* child = std::get_if<ElementPtr>(&property->value); child && *child)
                announce(**child);
    }

    bool isShared(const Element& element) const {
        return top_.contains(&element) || occurrences_.at(&element) > 1;
    }
    const std::string& idOf(const Element& element) {
        std::string& id = newIds_[&element];
        if (id.empty()) id = element.id;
        for (size_t number = newIds_.size(); id.empty(); ++number)
            if (const std::string candidate = fmt::format("object-{}", number); ids_.insert(candidate).second)
                id = candidate;
        return id;
    }

    void contents(const Element& element, std::string& xml, int depth) {
        for (const Property* property : contentsOf(element)) {
            const std::string name = nameOf(element, *property);
            const std::string indent(static_cast<size_t>(4 * depth), ' ');
            if (const ElementPtr* child = std::get_if<ElementPtr>(&property->value)) {
                if (*child) object(element, **child, name, xml, depth);
            } else {
                xml += indent + value(element, name, *property) + "\n";
            }
        }
    }

    void object(const Element& parent, const Element& element, const std::string& name, std::string& xml,
                int depth) {
        const std::string indent(static_cast<size_t>(4 * depth), ' ');
        const std::string nameText =
            name.empty() || &parent == scene_.root.get() ? "" : fmt::format(" name=\"{}\"", escaped(name));
        const bool isTop = &parent == scene_.root.get();
        // An object of the scene is written there, another one where it is seen first.
        if ((top_.contains(&element) && !isTop) || !written_.insert(&element).second) {
            if (!isTop)
                xml += fmt::format("{}<ref{} id=\"{}\"/>\n", indent, nameText, escaped(idOf(element)));
            return;
        }
        const std::string idText =
            isShared(element) || !element.id.empty() ? fmt::format(" id=\"{}\"", escaped(idOf(element))) : "";
        const bool isMesh = element.type == "mesh" && element.find("arrays");
        xml += fmt::format("{}<{} type=\"{}\"{}{}>\n", indent, element.tag,
                           isMesh ? "ply" : escaped(element.type), idText, nameText);
        contents(element, xml, depth + 1);
        xml += fmt::format("{}</{}>\n", indent, element.tag);
    }

    std::string fileProperty(const std::string& name) const {
        return fmt::format("<string name=\"filename\" value=\"{}\"/>",
                           escaped(fmt::format("{}/{}", folder_, name)));
    }
    std::string newFile(const Property& property, const char* extension, std::string bytes) {
        const auto [entry, isNew] = names_.try_emplace(std::visit(OwnerOf{}, property.value));
        if (isNew) {
            entry->second = fmt::format("{:04}.{}", names_.size(), extension);
            files_.emplace_back(entry->second, std::move(bytes));
        }
        return entry->second;
    }

    /// Names of files are found from the new place.
    std::string relocated(const Element& element, const std::string& filename) const {
        try {
            const fs::path found = findFile(filename, element.location.file, scene_.searchPaths);
            const fs::path base = fs::weakly_canonical(fs::absolute(file_)).parent_path();
            return fs::weakly_canonical(fs::absolute(found)).lexically_proximate(base).string();
        } catch (const Error& problem) {
            throw element.error(problem.what());
        }
    }

    std::string value(const Element& element, const std::string& name, const Property& property) {
        const bool isOldName = name == "disable_vertex_normals";  // of 2.0
        const std::string named = fmt::format("name=\"{}\"", isOldName ? "face_normals" : escaped(name));
        struct Write {
            Writer& writer;
            const Element& element;
            const std::string& name;
            const std::string& named;
            const Property& property;

            std::string plain(const char* tag, const std::string& text) const {
                return fmt::format("<{} {} value=\"{}\"/>", tag, named, text);
            }
            std::string operator()(bool v) const { return plain("boolean", v ? "true" : "false"); }
            std::string operator()(int64_t v) const { return plain("integer", std::to_string(v)); }
            std::string operator()(double v) const { return plain("float", text(v)); }
            std::string operator()(const std::string& v) const {
                return plain("string", escaped(name == "filename" ? writer.relocated(element, v) : v));
            }
            std::string operator()(const Vec3d& v) const {
                return fmt::format("<point {} x=\"{}\" y=\"{}\" z=\"{}\"/>", named, v.x, v.y, v.z);
            }
            std::string operator()(const Transform& map) const {
                std::string steps = property.text;
                if (steps.empty()) {
                    for (int i = 0; i < 16; ++i)
                        steps += fmt::format("{}{}", i > 0 ? " " : "", map.at(i / 4, i % 4));
                    steps = fmt::format("<matrix value=\"{}\"/>", steps);
                }
                return fmt::format("<transform {}>{}</transform>", named, steps);
            }
            std::string operator()(const RgbValue& v) const {
                return plain("rgb", fmt::format("{}, {}, {}", double(v.value[0]), double(v.value[1]),
                                                double(v.value[2])));
            }
            std::string operator()(const SpectrumValue& s) const {
                if (s.blackbodyKelvin > 0)
                    return fmt::format("<blackbody {} temperature=\"{}\" scale=\"{}\"/>", named,
                                       double(s.blackbodyKelvin), double(s.values[0]));
                std::string list;
                for (size_t i = 0; i < s.values.size(); ++i)
                    list += fmt::format("{}{}{}", i > 0 ? ", " : "",
                                        s.wavelengths.empty() ? "" : text(double(s.wavelengths[i])) + ":",
                                        double(s.values[i]));
                return plain("spectrum", list);
            }
            std::string operator()(const MeshArrays& mesh) const {
                return writer.fileProperty(writer.newFile(property, "ply", plyOf(mesh)));
            }
            std::string operator()(const PixelArray& pixels) const {
                return writer.fileProperty(writer.newFile(property, "exr", exrOf(pixels)));
            }
            std::string operator()(const VoxelArray& voxels) const {
                return writer.fileProperty(writer.newFile(property, "vol", volOf(voxels)));
            }
            std::string operator()(const ElementPtr&) const { return {}; }
        };
        return std::visit(Write{*this, element, name, named, property}, property.value);
    }

    const ParsedScene& scene_;
    fs::path file_;
    std::string folder_;
    std::set<const Element*> top_, written_;
    std::map<const Element*, int> occurrences_;
    std::map<const Element*, std::string> newIds_;
    std::set<std::string> ids_;
    std::map<const void*, std::string> names_;  ///< of files, by what owns their content
    std::vector<std::pair<std::string, std::string>> files_;
};

}  // namespace

std::vector<fs::path> writeScene(const ParsedScene& scene, const fs::path& file) {
    return Writer(scene, file).run();
}

}  // namespace metrolux::core::mitsuba
