#include "io/gltf/scene.h"

#include "io/gltf/materials.h"
#include "io/mitsuba/maker.h"
#include "io/mitsuba/world_origin.h"

#include <algorithm>
#include <fstream>

namespace metrolux::core::gltf {
namespace {

using namespace mitsuba;

constexpr int kMaxNodeDepth = 256;
constexpr int kDefaultHeight = 720;
constexpr double kDegrees = 180 / std::numbers::pi;

const std::vector<std::string> kExtensions = {
    "KHR_materials_transmission", "KHR_materials_ior",
    "KHR_materials_volume",       "KHR_materials_emissive_strength",
    "KHR_materials_specular",     "KHR_materials_clearcoat",
    "KHR_materials_unlit",        "KHR_materials_pbrSpecularGlossiness",
    "KHR_lights_punctual",        "KHR_texture_transform",
    "KHR_mesh_quantization"};

/// A mesh of the file, as shapes without a place.
struct Part {
    MeshArrays arrays;
    ElementPtr bsdf, emitter, interior;
    bool flat = false;  ///< without normals
    Location location;
    Box box;
};

/// What MeshArrays show.
struct Arrays {
    std::vector<float> positions, normals, uvs, colors;
    std::vector<uint32_t> triangles;
};

core::Transform toCamera() {  // they look along -z, with +x to the right
    return core::Transform::fromRows({{-1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, 1}});
}

/// Without the lengths of the axes, which have no effect on cameras and lights.
core::Transform unscaled(const core::Transform& map) {
    double rows[4][4] = {
        {0, 0, 0, map.at(0, 3)}, {0, 0, 0, map.at(1, 3)}, {0, 0, 0, map.at(2, 3)}, {0, 0, 0, 1}};
    for (int j = 0; j < 3; ++j) {
        const double length = std::hypot(map.at(0, j), map.at(1, j), map.at(2, j));
        for (int i = 0; i < 3; ++i) rows[i][j] = map.at(i, j) / (length > 0 ? length : 1);
    }
    return core::Transform::fromRows(rows);
}

core::Transform localTransform(const Node& node) {
    if (node.has("matrix")) {
        const auto m = node.numbers("matrix", std::vector<double>(16));
        double rows[4][4];
        for (size_t i = 0; i < 16; ++i) rows[i % 4][i / 4] = m[i];
        return core::Transform::fromRows(rows);
    }
    const auto t = node.numbers("translation", {0, 0, 0}), q = node.numbers("rotation", {0, 0, 0, 1}),
               s = node.numbers("scale", {1, 1, 1});
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 0)) throw node.error("found a \"rotation\" of length zero, expected a unit quaternion");
    const double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                            {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                            {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    double rows[4][4] = {{0, 0, 0, t[0]}, {0, 0, 0, t[1]}, {0, 0, 0, t[2]}, {0, 0, 0, 1}};
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) rows[i][j] = r[i][j] * s[j];
    return core::Transform::fromRows(rows);
}

class Builder {
  public:
    Builder(const std::filesystem::path& file, bool lenient, MemoryBudget& memory)
        : document_(file, memory),
          memory_(memory),
          materials_(document_, memory, warnings_),
          scene_("scene", "", {file.string(), 0, ""}) {
        checkExtensions(lenient);
    }

    ParsedScene run() {
        const Node scenes = document_.root().at("scenes");
        if (scenes.size() == 0) throw document_.root().error("has no \"scenes\", expected one at least");
        const Node scene =
            scenes.at(static_cast<size_t>(std::max<int64_t>(document_.root().index("scene"), 0)));
        countUses(scene.at("nodes"), 0);
        visited_.clear();
        placeAll(scene.at("nodes"), core::Transform(), 0);
        if (sensors_ == 0) addCamera();
        if (!hasLight_) {
            warnings_.emplace_back(scene.error("has no light: a white sky stands in").what());
            scene_.containing(Maker("emitter", "constant", locationOf(scene)).done());
        }
        for (const char* left : {"animations", "skins"})
            if (document_.root().at(left).size() > 0)
                warnings_.emplace_back(
                    document_.root().at(left).error("scenes do not move: they are left out").what());
        ParsedScene result;
        result.root = scene_.done();
        result.searchPaths = {std::filesystem::path(document_.root().file()).parent_path()};
        result.files = document_.files();
        result.warnings = std::move(warnings_);
        return result;
    }

  private:
    static Location locationOf(const Node& node) { return {node.file(), 0, node.path()}; }
    void warn(const Node& node, const std::string& message) {
        warnings_.emplace_back(node.error(message).what());
    }

    void checkExtensions(bool lenient) {
        const Node required = document_.root().at("extensionsRequired");
        for (const Json& name : required.json()) {
            if (!name.is_string() || std::find(kExtensions.begin(), kExtensions.end(),
                                               name.get<std::string>()) != kExtensions.end())
                continue;
            const Error error = required.error(fmt::format(
                "the extension {} is not supported, and the file requires it", name.get<std::string>()));
            if (!lenient) throw error;
            warnings_.emplace_back(error.what());
        }
    }

    /// Calls action(node, index) for the nodes of a list and then for those below them, each node once.
    template <class Action>
    void descend(const Node& list, int depth, const Action& action) {
        if (depth > kMaxNodeDepth)
            throw list.error(fmt::format("nodes are nested more than {} levels deep", kMaxNodeDepth));
        for (const Json& entry : list.json()) {
            if (!entry.is_number_unsigned()) throw list.error("found a node that is no number");
            const auto index = entry.get<size_t>();
            const Node node = document_.element("nodes", index);
            if (!visited_.insert(index).second) throw node.error("is below more than one node");
            action(node);
        }
    }
    void countUses(const Node& list, int depth) {
        descend(list, depth, [&](const Node& node) {
            if (node.has("mesh")) ++uses_[node.index("mesh")];
            countUses(node.at("children"), depth + 1);
        });
    }
    void placeAll(const Node& list, const core::Transform& above, int depth) {
        descend(list, depth, [&](const Node& node) {
            const core::Transform map = settledMap(above * localTransform(node));
            if (node.has("mesh")) addMesh(node, map);
            if (node.has("camera")) addCamera(node, map);
            const Node light = node.extension("KHR_lights_punctual");
            if (light.has("light")) addLight(light, map);
            placeAll(node.at("children"), map, depth + 1);
        });
    }

    void addMesh(const Node& node, const core::Transform& map) {
        const int64_t index = node.index("mesh");
        const auto [entry, isNew] = meshes_.try_emplace(index);
        if (isNew) entry->second = readMesh(document_.element("meshes", static_cast<size_t>(index)));
        const std::vector<Part>& parts = entry->second;
        const bool emits =
            std::any_of(parts.begin(), parts.end(), [](const Part& p) { return p.emitter != nullptr; });
        hasLight_ = hasLight_ || emits;
        for (const Part& part : parts) boxes_.push_back(boxUnder(map, part.box));
        if (uses_[index] > 1 && !emits && !map.isSingular() && !parts.empty()) {
            ElementPtr& group = groups_[index];
            if (!group) {
                Maker made("shape", "shapegroup", parts.front().location);
                for (const Part& part : parts) made.containing(shapeOf(part, core::Transform()));
                group = made.done();
            }
            scene_.containing(
                Maker("shape", "instance", locationOf(node)).with("to_world", map).containing(group).done());
            return;
        }
        for (const Part& part : parts) scene_.containing(shapeOf(part, map));
    }

    static ElementPtr shapeOf(const Part& part, const core::Transform& map) {
        Maker shape("shape", "mesh", part.location);
        shape.with("arrays", part.arrays)
            .with("to_world", map)
            .containing(part.bsdf)
            .containing(part.emitter);
        if (part.interior) shape.with("interior", part.interior);
        if (part.flat) shape.with("face_normals", true);
        return shape.done();
    }

    std::vector<Part> readMesh(const Node& mesh) {
        std::vector<Part> result;
        const Node primitives = mesh.at("primitives");
        for (size_t i = 0; i < primitives.size(); ++i) {
            const Node primitive = primitives.at(i);
            if (primitive.at("targets").size() > 0)
                warn(primitive, "scenes do not move: its morph targets are left out");
            const int64_t mode = primitive.has("mode") ? primitive.index("mode") : 4;
            if (mode < 4) {
                warn(primitive, "points and lines are left out");
                continue;
            }
            if (mode > 6) throw primitive.error(fmt::format("found the mode {}, expected 0 to 6", mode));
            result.push_back(readPrimitive(primitive, mode));
        }
        return result;
    }

    Part readPrimitive(const Node& primitive, int64_t mode) {
        const Node attributes = primitive.at("attributes");
        if (!attributes.has("POSITION")) throw primitive.error("has no POSITION");
        auto data = std::make_shared<Arrays>();
        const auto read = [&](const char* name, int components) {
            return document_.floats(static_cast<size_t>(attributes.index(name)), components);
        };
        data->positions = read("POSITION", 3);
        if (attributes.has("NORMAL")) data->normals = read("NORMAL", 3);
        if (attributes.has("TEXCOORD_0")) data->uvs = read("TEXCOORD_0", 2);
        const int64_t material = primitive.index("material");
        if (attributes.has("COLOR_0")) readColors(attributes, material, *data);
        const size_t vertices = data->positions.size() / 3;
        std::vector<uint32_t> indices;
        if (primitive.has("indices")) {
            indices = document_.indices(static_cast<size_t>(primitive.index("indices")));
        } else {
            memory_.require(vertices * sizeof(uint32_t), "the indices");
            for (uint32_t v = 0; v < vertices; ++v) indices.push_back(v);
        }
        // Any number of primitives may show one accessor.
        memory_.take((data->positions.size() + data->normals.size() + data->uvs.size() + data->colors.size() +
                      3 * indices.size()) *
                         sizeof(float),
                     "the mesh");
        data->triangles = triangles(indices, mode);

        Part part;
        part.location = locationOf(primitive);
        part.flat = data->normals.empty();
        part.bsdf = materials_.bsdf(material, !data->colors.empty());
        part.emitter = materials_.emitter(material);
        part.interior = materials_.interior(material);
        part.box = {Vec3d(0.0), Vec3d(0.0)};
        for (size_t v = 0; v < vertices; ++v)
            for (int axis = 0; axis < 3; ++axis) {
                const double x = double(data->positions[3 * v + static_cast<size_t>(axis)]);
                part.box.lower[axis] = v == 0 ? x : std::min(part.box.lower[axis], x);
                part.box.upper[axis] = v == 0 ? x : std::max(part.box.upper[axis], x);
            }
        part.arrays = {data->positions, data->normals, data->uvs, data->triangles, {}, data};
        if (!data->colors.empty()) part.arrays.attributes.push_back({"vertex_color", 3, data->colors});
        return part;
    }

    /// Without their opacity, times the material's color.
    void readColors(const Node& attributes, int64_t material, Arrays& data) {
        const auto accessor = static_cast<size_t>(attributes.index("COLOR_0"));
        const int components = document_.components(accessor);
        const std::vector<float> values = document_.floats(accessor, components);
        if (components < 3) throw attributes.error("found a COLOR_0 that is neither VEC3 nor VEC4");
        const Rgb factor = materials_.baseColorFactor(material);
        for (size_t i = 0; i < values.size(); i += static_cast<size_t>(components))
            for (int c = 0; c < 3; ++c) data.colors.push_back(values[i + static_cast<size_t>(c)] * factor[c]);
    }

    static std::vector<uint32_t> triangles(const std::vector<uint32_t>& indices, int64_t mode) {
        if (mode == 4)
            return {indices.begin(), indices.end() - static_cast<std::ptrdiff_t>(indices.size() % 3)};
        std::vector<uint32_t> result;
        for (size_t i = 2; i < indices.size(); ++i) {
            if (mode == 6)
                result.insert(result.end(), {indices[0], indices[i - 1], indices[i]});
            else if (i % 2 == 0)
                result.insert(result.end(), {indices[i - 2], indices[i - 1], indices[i]});
            else
                result.insert(result.end(), {indices[i - 1], indices[i - 2], indices[i]});
        }
        return result;
    }

    ElementPtr film(const Node& node, double aspect) const {
        if (!(aspect > 0.01 && aspect < 100)) aspect = 16.0 / 9;
        return Maker("film", "hdrfilm", locationOf(node))
            .with("width", int64_t(std::lround(aspect * kDefaultHeight)))
            .with("height", int64_t{kDefaultHeight})
            .done();
    }

    void addCamera(const Node& node, const core::Transform& map) {
        const Node camera = document_.element("cameras", static_cast<size_t>(node.index("camera")));
        const std::string type = camera.string("type", "");
        const Node own = camera.at(type.c_str());
        const std::string name = camera.string("name", node.string("name", ""));
        const core::Transform place = settledMap(unscaled(map) * toCamera());
        Maker sensor("sensor", type == "orthographic" ? type : "perspective", locationOf(camera));
        if (!name.empty() && names_.insert(name).second) sensor.id(name);
        if (type == "orthographic") {
            const double x = own.number("xmag", 1), y = own.number("ymag", 1);
            sensor.with("to_world", settledMap(place * core::Transform::scale({float(x), float(x), 1})))
                .containing(film(camera, x / y));
        } else if (type == "perspective") {
            sensor.with("to_world", place)
                .with("fov", own.number("yfov", 0.8) * kDegrees)
                .with("fov_axis", std::string("y"))
                .containing(film(camera, own.number("aspectRatio", 0)));
        } else {
            throw camera.error(
                fmt::format("found the type \"{}\", expected perspective or orthographic", type));
        }
        if (const double near = own.number("znear", 0); near > 0) sensor.with("near_clip", near);
        scene_.containing(sensor.done());
        ++sensors_;
    }

    /// From the front and above, so that everything is seen.
    void addCamera() {
        const Node root = document_.root();
        warnings_.emplace_back(
            root.error("has no camera in its scene: one that sees all of it stands in").what());
        Vec3d lower(-1.0), upper(1.0);
        for (size_t i = 0; i < boxes_.size(); ++i)
            for (int axis = 0; axis < 3; ++axis) {
                lower[axis] = i == 0 ? boxes_[i].lower[axis] : std::min(lower[axis], boxes_[i].lower[axis]);
                upper[axis] = i == 0 ? boxes_[i].upper[axis] : std::max(upper[axis], boxes_[i].upper[axis]);
            }
        constexpr double kFov = 40;
        const Vec3d center = (lower + upper) * 0.5;
        const double radius = std::max((upper - lower).length() * 0.5, 1e-6);
        const Vec3d eye = center + Vec3d(0.5, 0.4, 1).normalized() * (radius / std::sin(kFov / 2 / kDegrees));
        scene_.containing(Maker("sensor", "perspective", {root.file(), 0, "default camera"})
                              .with("to_world", core::Transform::lookAt(eye, center, Vec3f(0, 1, 0)))
                              .with("fov", kFov)
                              .with("fov_axis", std::string("y"))
                              .with("near_clip", radius * 1e-3)
                              .containing(film(root, 0))
                              .done());
    }

    void addLight(const Node& reference, const core::Transform& map) {
        const Node light = document_.root()
                               .extension("KHR_lights_punctual")
                               .at("lights")
                               .at(static_cast<size_t>(reference.index("light")));
        const std::string type = light.string("type", "");
        const auto tint = light.numbers("color", {1, 1, 1});
        const double strength = light.number("intensity", 1);
        const RgbValue value{
            {float(tint[0] * strength), float(tint[1] * strength), float(tint[2] * strength)}};
        const core::Transform place = settledMap(unscaled(map) * toCamera());
        if (light.has("range"))
            warn(light, "\"range\" has no effect: light falls off with the square of the distance");
        if (type == "directional") {
            scene_.containing(Maker("emitter", "directional", locationOf(light))
                                  .with("to_world", place)
                                  .with("irradiance", value)
                                  .done());
        } else if (type == "point") {
            scene_.containing(Maker("emitter", "point", locationOf(light))
                                  .with("to_world", place)
                                  .with("intensity", value)
                                  .done());
        } else if (type == "spot") {
            const Node cone = light.at("spot");
            scene_.containing(
                Maker("emitter", "spot", locationOf(light))
                    .with("to_world", place)
                    .with("intensity", value)
                    .with("beam_width", cone.number("innerConeAngle", 0) * kDegrees)
                    .with("cutoff_angle", cone.number("outerConeAngle", std::numbers::pi / 4) * kDegrees)
                    .done());
        } else {
            throw light.error(
                fmt::format("found the type \"{}\", expected point, spot or directional", type));
        }
        hasLight_ = true;
    }

    Document document_;
    MemoryBudget& memory_;
    std::vector<std::string> warnings_;
    Materials materials_;
    Maker scene_;
    std::map<int64_t, int> uses_;  ///< of meshes
    std::map<int64_t, std::vector<Part>> meshes_;
    std::map<int64_t, ElementPtr> groups_;
    std::set<size_t> visited_;
    std::set<std::string> names_;  ///< of sensors
    std::vector<Box> boxes_;
    int sensors_ = 0;
    bool hasLight_ = false;
};

}  // namespace

bool isGltf(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (extension == ".gltf" || extension == ".glb") return true;
    char head[4] = {};
    std::ifstream(file, std::ios::binary).read(head, sizeof head);
    return std::string_view(head, 4) == "glTF";
}

ParsedScene parseGltf(const std::filesystem::path& file, bool lenient, MemoryBudget& memory) {
    try {
        return Builder(file, lenient, memory).run();
    } catch (const Json::exception& problem) {
        throw Error("{}: {}", file.string(), problem.what());
    }
}

}  // namespace metrolux::core::gltf
