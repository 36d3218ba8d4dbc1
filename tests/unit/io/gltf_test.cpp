/// glTF 2.0: what materials, lights and cameras become, against closed forms. A material without a specular
/// part (KHR_materials_ior 1) of roughness 1 reflects base color / pi where light and view are normal to it.

#include "gltf_support.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Not;

Json matte(const Json& color, const Json& more = Json::object()) {
    Json result{
        {"pbrMetallicRoughness", {{"baseColorFactor", color}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
        {"extensions", {{"KHR_materials_ior", {{"ior", 1}}}}}};
    result.merge_patch(more);
    return result;
}

/// A quad in the light of a lamp of 8 at z = 2: color / pi * 8 / 4.
GltfMaker lit(const std::function<size_t(GltfMaker&)>& addQuad) {
    GltfMaker maker;
    maker.node({{"mesh", addQuad(maker)}});
    Json lamp = GltfMaker::lightNode(maker.light({{"type", "point"}, {"intensity", 8}}));
    lamp["translation"] = {0, 0, 2};
    maker.node(lamp);
    maker.camera();
    return maker;
}
Rgb reflected(const Rgb& color) { return color * (2 / kPi); }

TEST(Gltf, pointLightOnAMatteQuad) {
    expectColor(seen(lit([](GltfMaker& m) {
                    return m.quad(matte({0.8, 0.4, 0.2, 1}));
                })),
                reflected({0.8f, 0.4f, 0.2f}));
}

TEST(Gltf, lightsOfEachKind) {
    const auto with = [](const Json& light, const Json& node) {
        GltfMaker maker;
        maker.node({{"mesh", maker.quad(matte({0.5, 0.5, 0.5, 1}))}});
        Json lamp = GltfMaker::lightNode(maker.light(light));
        lamp.update(node);
        maker.node(lamp);
        maker.camera();
        return seen(maker);
    };
    // Lights shine along -z, as cameras look.
    expectColor(with({{"type", "directional"}, {"color", {1, 0.5, 0}}, {"intensity", 3}}, Json::object()),
                Rgb(1, 0.5f, 0) * (0.5f / kPi * 3));
    expectGray(with({{"type", "spot"}, {"intensity", 12}, {"spot", {{"innerConeAngle", 0.3}}}},
                    {{"translation", {0, 0, 2}}}),
               0.5f / kPi * 12 / 4);
    // Turned away by half a turn around y.
    expectGray(
        with({{"type", "spot"}, {"intensity", 12}}, {{"translation", {0, 0, 2}}, {"rotation", {0, 1, 0, 0}}}),
        0);
}

TEST(Gltf, emissionAndItsStrength) {
    GltfMaker maker;
    maker.node({{"mesh",
                 maker.quad({{"emissiveFactor", {1, 0.5, 0.25}},
                             {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 6}}}}},
                             {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}})}});
    maker.camera();
    expectColor(seen(maker), {6, 3, 1.5f});
}

/// Four texels: red green / blue white, in sRGB.
ImageData fourTexels() { return {2, 2, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}}; }

TEST(Gltf, texturesInTheFileAndTheirTransform) {
    // Scaled and moved into one texel each. The first row of the image is at v = 0.
    for (const auto& [offset, color] : {std::pair(Vec2f(0.2f, 0.2f), Rgb(1, 0, 0)),
                                        {{0.7f, 0.2f}, {0, 1, 0}},
                                        {{0.2f, 0.7f}, {0, 0, 1}},
                                        {{0.7f, 0.7f}, {1, 1, 1}}}) {
        const Rgb found = seen(lit([&, o = offset](GltfMaker& m) {
            Json material = matte({1, 1, 1, 1});
            material["pbrMetallicRoughness"]["baseColorTexture"] = {
                {"index", m.texture(fourTexels())},
                {"extensions",
                 {{"KHR_texture_transform", {{"offset", {o.x, o.y}}, {"scale", {0.01, 0.01}}}}}}};
            m.json["samplers"] = {{{"magFilter", 9728}}};
            m.json["textures"][0]["sampler"] = 0;
            return m.quad(material);
        }));
        expectColor(found, reflected(color));
    }
    // A quarter turn, counterclockwise in the image's space: what was at (u, v) is now looked up at (v, -u).
    const Rgb turned = seen(lit([&](GltfMaker& m) {
        Json material = matte({1, 1, 1, 1});
        material["pbrMetallicRoughness"]["baseColorTexture"] = {
            {"index", m.texture(fourTexels())},
            {"extensions",
             {{"KHR_texture_transform",
               {{"offset", {0.2, 0.2}}, {"rotation", 1.5707963}, {"scale", {1, 0.001}}}}}}};
        m.json["samplers"] = {{{"magFilter", 9728}}};
        m.json["textures"][0]["sampler"] = 0;
        return m.quad(material);
    }));
    expectColor(turned,
                reflected({0, 0, 1}));  // u = 0.5 becomes v = 0.2 - 0.5 = 0.7 of the repetition before
}

TEST(Gltf, colorsOfVertices) {
    const Rgb found = seen(lit([](GltfMaker& m) {
        const size_t colors =
            m.accessor(std::vector<uint8_t>{255, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255},
                       5121, "VEC4", 4);
        m.json["accessors"][colors]["normalized"] = true;
        return m.quad(matte({0.5, 1, 1, 1}), {{"COLOR_0", colors}});
    }));
    expectColor(found, reflected({0.5f, 0, 0}));
}

TEST(Gltf, opacityOfEachMode) {
    const auto behind = [](const char* mode, double alpha) {
        GltfMaker maker;  // a black veil in front of a white sky
        maker.node({{"mesh", maker.quad({{"alphaMode", mode},
                                         {"pbrMetallicRoughness",
                                          {{"baseColorFactor", {0, 0, 0, alpha}}, {"metallicFactor", 1}}},
                                         {"extensions", {{"KHR_materials_ior", {{"ior", 1}}}}}})}});
        maker.camera();
        return seen(maker, 1000);
    };
    expectGray(behind("BLEND", 0.25), 0.75f);
    expectGray(behind("MASK", 0.25), 1);
    expectGray(behind("MASK", 0.75), 0);
    expectGray(behind("OPAQUE", 0.25), 0);
}

/// Nothing is absorbed in front of a white sky: a furnace. Of a thin sheet, and of a closed body with volume.
TEST(Gltf, transmissionLosesNothing) {
    const Json clear{{"pbrMetallicRoughness",
                      {{"baseColorFactor", {1, 1, 1, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0}}},
                     {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}};
    GltfMaker sheet;
    sheet.node({{"mesh", sheet.quad(clear)}});
    sheet.camera();
    expectGray(seen(sheet), 1);

    Json solid = clear;
    solid["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
    solid["extensions"]["KHR_materials_ior"] = {{"ior", 1.33}};
    GltfMaker body;
    const size_t mesh = body.quad(solid);
    // The six sides of a cube of 2.
    for (const auto& [rotation, place] : {std::pair(Json{0, 0, 0, 1}, Json{0, 0, 1}),
                                          {{0, 1, 0, 0}, {0, 0, -1}},
                                          {{0, 0.70710678, 0, 0.70710678}, {1, 0, 0}},
                                          {{0, -0.70710678, 0, 0.70710678}, {-1, 0, 0}},
                                          {{-0.70710678, 0, 0, 0.70710678}, {0, 1, 0}},
                                          {{0.70710678, 0, 0, 0.70710678}, {0, -1, 0}}})
        body.node({{"mesh", mesh}, {"rotation", rotation}, {"translation", place}});
    body.camera();
    const SceneParts parts = loaded(body);
    EXPECT_EQ(parts.instances.size(), 6u) << "a mesh that is used several times is kept once";
    EXPECT_TRUE(parts.shapes.empty());
    expectGray(seen(body), 1);
}

TEST(Gltf, bodiesAbsorb) {
    const auto made = [](const Json& volume) {
        GltfMaker maker;
        Json material{{"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}};
        material["extensions"]["KHR_materials_volume"] = volume;
        const size_t mesh = maker.quad(material);
        maker.node({{"mesh", mesh}});
        maker.camera();
        return loaded(maker);
    };
    const Json glass{
        {"thicknessFactor", 1}, {"attenuationDistance", 2}, {"attenuationColor", {1, 0.5, 0.25}}};
    const SceneParts parts = made(glass);
    ASSERT_EQ(parts.media.size(), 1u);
    EXPECT_EQ(parts.shapes.at(0)->media.value().interior, 1);
    EXPECT_EQ(parts.shapes.at(0)->media.value().exterior, 0);
    const Rgb passed = parts.media[0]->thickness(Vec3f(0.0f), {0, 0, 1}, 2);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(std::exp(-passed[c]), (Rgb(1, 0.5f, 0.25f)[c]), 1e-6);
    EXPECT_FALSE(parts.media[0]->scatters());
    // Without a thickness, a distance or a color nothing is absorbed.
    for (const char* without : {"thicknessFactor", "attenuationDistance", "attenuationColor"}) {
        Json volume = glass;
        volume.erase(without);
        EXPECT_TRUE(made(volume).media.empty()) << without;
    }
    Json bad = glass;
    bad["attenuationDistance"] = 0;
    EXPECT_THAT(errorOf([&] { made(bad); }), HasSubstr("attenuationDistance"));
    bad = glass;
    bad["attenuationColor"] = {2, 0, 0};
    EXPECT_THAT(errorOf([&] { made(bad); }), HasSubstr("attenuationColor"));
}

TEST(Gltf, specularAndIndexSetTheReflectionAtNormalIncidence) {
    const auto found = [](const Json& extensions) {
        GltfMaker maker;  // a black dielectric mirrors the white sky
        maker.node(
            {{"mesh",
              maker.quad(
                  {{"pbrMetallicRoughness",
                    {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.05}}},
                   {"extensions", extensions}})}});
        maker.camera();
        return seen(maker);
    };
    expectGray(found(Json::object()), 0.04f);
    expectGray(found({{"KHR_materials_ior", {{"ior", 2}}}}), 1 / 9.0f);
    expectGray(found({{"KHR_materials_specular", {{"specularFactor", 0.5}}}}), 0.02f);
}

TEST(Gltf, nodesPlaceThings) {
    GltfMaker maker;
    const size_t mesh = maker.quad(nullptr);
    maker.json["nodes"] = {{{"mesh", mesh}, {"matrix", {0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 5, 0, 0, 1}}},
                           {{"children", {0}}, {"translation", {0, 0, -7}}, {"scale", {1, 3, 1}}}};
    maker.json["scenes"][0]["nodes"] = {1};
    const SceneParts parts = loaded(maker);
    Vec3f lower, upper;
    parts.shapes.at(0)->bounds(lower, upper);
    EXPECT_NEAR((lower - Vec3f(3, -6, -7)).length(), 0, 1e-5);
    EXPECT_NEAR((upper - Vec3f(7, 6, -7)).length(), 0, 1e-5);
    EXPECT_THAT(parts.warnings, Contains(HasSubstr("no camera")));
    EXPECT_THAT(parts.warnings, Contains(HasSubstr("no light")));
    SurfaceInteraction si;
    const Vec3f eye = parts.camera->position();
    EXPECT_GT(eye.z, -7) << "the camera that stands in looks from the front";
}

TEST(Gltf, binaryIsTheSame) {
    const GltfMaker maker = lit([](GltfMaker& m) { return m.quad(matte({0.8, 0.4, 0.2, 1})); });
    const TemporaryFolder folder;
    LoadOptions options;
    options.setResolution(8, 6);
    const auto image = [&](const char* name, const std::string& bytes) {
        return RenderableScene(folder.write(name, bytes), options).render("path", 2, 1);
    };
    EXPECT_EQ(image("a.gltf", maker.gltf()), image("a.glb", maker.glb()));
    folder.write("all of it.bin", maker.buffer);
    Json outside = maker.json;
    outside["buffers"] = {{{"byteLength", maker.buffer.size()}, {"uri", "all%20of%20it.bin"}}};
    EXPECT_EQ(image("a.gltf", maker.gltf()), image("b.gltf", outside.dump()));
}

TEST(Gltf, refusalsNameTheirPlace) {
    const auto refusal = [](const std::function<void(GltfMaker&)>& spoil) {
        GltfMaker maker = lit([](GltfMaker& m) { return m.quad(matte({0.5, 0.5, 0.5, 1})); });
        spoil(maker);
        return errorOf([&] { loaded(maker); });
    };
    EXPECT_THAT(refusal([](GltfMaker& m) { m.json["extensionsRequired"] = {"KHR_draco_mesh_compression"}; }),
                HasSubstr("scene.gltf:extensionsRequired: the extension KHR_draco_mesh_compression"));
    EXPECT_THAT(refusal([](GltfMaker& m) { m.json["accessors"][0]["count"] = 5000; }),
                HasSubstr("accessors.0: found 5000 elements"));
    EXPECT_THAT(refusal([](GltfMaker& m) { m.json["accessors"][0]["count"] = 1e14; }),
                HasSubstr("accessors.0"));
    EXPECT_THAT(refusal([](GltfMaker& m) { m.json["bufferViews"][0]["byteLength"] = 1e9; }),
                HasSubstr("bufferViews.0"));
    EXPECT_THAT(refusal([](GltfMaker& m) { m.json["nodes"][0]["mesh"] = 7; }),
                HasSubstr("meshes: found a reference to number 7, but there are 1"));
    EXPECT_THAT(refusal([](GltfMaker& m) { m.json["nodes"][0]["children"] = {0}; }),
                HasSubstr("nodes.0: is below more than one node"));
    EXPECT_THAT(refusal([](GltfMaker& m) {
                    m.json["nodes"][0]["scale"] = {1, 2};
                }),
                HasSubstr("nodes.0: \"scale\" has to have 3 numbers"));
    EXPECT_THAT(refusal([](GltfMaker& m) { m.json["materials"][0]["alphaMode"] = "GLOW"; }),
                HasSubstr("materials.0: found the alphaMode \"GLOW\""));
    EXPECT_THAT(refusal([](GltfMaker& m) { m.json["asset"]["version"] = "1.0"; }),
                HasSubstr("version \"1.0\", expected 2.0"));
    const TemporaryFolder folder;
    EXPECT_THAT(errorOf([&] { loadScene(folder.write("a.gltf", "{\"asset\""), {}); }),
                HasSubstr("is not JSON"));
    LoadOptions options;
    options.defines["x"] = "1";
    EXPECT_THAT(errorOf([&] { loadScene(folder.write("a.gltf", GltfMaker().gltf()), options); }),
                HasSubstr("has no parameters"));
}

}  // namespace
}  // namespace metrolux::core::test
