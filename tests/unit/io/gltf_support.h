#pragma once
/// glTF files made in code: quads, a camera close to their middle, and what a test adds.

#include "cases_support.h"
#include "image/image_io.h"

#include <nlohmann/json.hpp>

namespace metrolux::core::test {

using Json = nlohmann::json;

inline std::string base64(const std::string& bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string result;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k)
            result += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63u] : '=';
    }
    return result;
}

/// Collects data in one buffer.
class GltfMaker {
  public:
    Json json{{"asset", {{"version", "2.0"}}}, {"scene", 0}};

    GltfMaker() { json["scenes"] = {{{"nodes", Json::array()}}}; }

    size_t view(const std::string& bytes) {
        while (buffer.size() % 4 != 0) buffer += '\0';
        json["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}});
        buffer += bytes;
        return json["bufferViews"].size() - 1;
    }
    template <class T>
    size_t accessor(const std::vector<T>& values, int type, const char* shape, size_t components) {
        const size_t index = view({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
        json["accessors"].push_back({{"bufferView", index},
                                     {"componentType", type},
                                     {"count", values.size() / components},
                                     {"type", shape}});
        return json["accessors"].size() - 1;
    }
    size_t floats(const std::vector<float>& values, const char* shape, size_t components) {
        return accessor(values, 5126, shape, components);
    }
    size_t node(const Json& node) {
        json["nodes"].push_back(node);
        json["scenes"][0]["nodes"].push_back(json["nodes"].size() - 1);
        return json["nodes"].size() - 1;
    }
    /// [-1, 1]^2 at z = 0, toward +z, its texture's top at y = 1; `material` may be null.
    size_t quad(const Json& material, const Json& attributes = Json::object()) {
        Json primitive{{"attributes",
                        {{"POSITION", floats({-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, "VEC3", 3)},
                         {"NORMAL", floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3)},
                         {"TEXCOORD_0", floats({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2", 2)}}},
                       {"indices", accessor(std::vector<uint16_t>{0, 1, 2, 0, 2, 3}, 5123, "SCALAR", 1)}};
        primitive["attributes"].update(attributes);
        if (!material.is_null()) {
            json["materials"].push_back(material);
            primitive["material"] = json["materials"].size() - 1;
        }
        json["meshes"].push_back({{"primitives", Json::array({primitive})}});
        return json["meshes"].size() - 1;
    }
    /// At z = 3, it sees a spot around the origin.
    void camera() {
        json["cameras"].push_back(
            {{"type", "perspective"}, {"perspective", {{"yfov", 0.002}, {"aspectRatio", 4.0 / 3}}}});
        node({{"camera", json["cameras"].size() - 1}, {"translation", {0, 0, 3}}});
    }
    /// Number of a texture of these texels, as a PNG in the buffer.
    size_t texture(const ImageData& image) {
        json["images"].push_back({{"bufferView", view(encodePngRaw(image))}, {"mimeType", "image/png"}});
        json["textures"].push_back({{"source", json["images"].size() - 1}});
        return json["textures"].size() - 1;
    }
    size_t light(const Json& light) {
        json["extensions"]["KHR_lights_punctual"]["lights"].push_back(light);
        return json["extensions"]["KHR_lights_punctual"]["lights"].size() - 1;
    }
    static Json lightNode(size_t light) {
        return {{"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}};
    }

    std::string gltf() const {
        Json file = json;
        file["buffers"] = {{{"byteLength", buffer.size()},
                            {"uri", "data:application/octet-stream;base64," + base64(buffer)}}};
        return file.dump();
    }
    std::string glb() const {
        Json file = json;
        file["buffers"] = {{{"byteLength", buffer.size()}}};
        std::string text = file.dump(), binary = buffer;
        while (text.size() % 4 != 0) text += ' ';
        while (binary.size() % 4 != 0) binary += '\0';
        const auto word = [](uint32_t v) { return std::string(reinterpret_cast<const char*>(&v), 4); };
        const std::string chunks = word(static_cast<uint32_t>(text.size())) + "JSON" + text +
                                   word(static_cast<uint32_t>(binary.size())) + std::string("BIN\0", 4) +
                                   binary;
        return "glTF" + word(2) + word(static_cast<uint32_t>(12 + chunks.size())) + chunks;
    }

    std::string buffer;
};

inline SceneParts loaded(const GltfMaker& maker, const LoadOptions& options = {}) {
    const TemporaryFolder folder;
    return loadScene(folder.write("scene.gltf", maker.gltf()), options);
}

/// Mean radiance of what the camera sees.
inline Rgb seen(const GltfMaker& maker, int passes = 200) {
    const TemporaryFolder folder;
    LoadOptions options;
    options.setResolution(16, 12);
    const RenderableScene scene(folder.write("scene.gltf", maker.gltf()), options);
    return meanOf(scene.render("path", passes, 1));
}

}  // namespace metrolux::core::test
