/// Scenes of Mitsuba 0.x become what their 3.x twins are.

#include "io/mitsuba/upgrade.h"

#include "support.h"

#include <gmock/gmock.h>

namespace metrolux::core {
namespace {

using mitsuba::Element;
using mitsuba::ElementPtr;
using mitsuba::Property;
using mitsuba::RgbValue;
using mitsuba::SpectrumValue;
using test::parseText;
using test::scene;

void expectSame(const Element& a, const Element& b);

struct SameValue {
    void operator()(const Transform& a, const Transform& b) const {
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) EXPECT_DOUBLE_EQ(a.at(i, j), b.at(i, j));
    }
    void operator()(const RgbValue& a, const RgbValue& b) const { EXPECT_EQ(a.value, b.value); }
    void operator()(const SpectrumValue& a, const SpectrumValue& b) const {
        EXPECT_EQ(a.wavelengths, b.wavelengths);
        EXPECT_EQ(a.values, b.values);
        EXPECT_EQ(a.blackbodyKelvin, b.blackbodyKelvin);
    }
    void operator()(const ElementPtr& a, const ElementPtr& b) const { expectSame(*a, *b); }
    void operator()(const mitsuba::MeshArrays&, const mitsuba::MeshArrays&) const {
        ADD_FAILURE() << "no file has these";
    }
    void operator()(const mitsuba::PixelArray&, const mitsuba::PixelArray&) const {
        ADD_FAILURE() << "no file has these";
    }
    void operator()(const mitsuba::VoxelArray&, const mitsuba::VoxelArray&) const {
        ADD_FAILURE() << "no file has these";
    }
    template <class T>
    void operator()(const T& a, const T& b) const {
        EXPECT_EQ(a, b);
    }
    template <class A, class B>
    void operator()(const A&, const B&) const {
        ADD_FAILURE() << "values of different types";
    }
};

void expectSame(const Element& a, const Element& b) {
    SCOPED_TRACE(a.location.str() + " " + a.tag + " " + a.type);
    EXPECT_EQ(a.tag, b.tag);
    EXPECT_EQ(a.type, b.type);
    EXPECT_EQ(a.id, b.id);
    ASSERT_EQ(a.named.size(), b.named.size());
    ASSERT_EQ(a.children.size(), b.children.size());
    for (const auto& [name, property] : a.named) {
        SCOPED_TRACE(name);
        const Property* other = b.find(name);
        ASSERT_TRUE(other);
        std::visit(SameValue{}, property.value, other->value);
    }
    for (size_t i = 0; i < a.children.size(); ++i)
        std::visit(SameValue{}, a.children[i].value, b.children[i].value);
}

TEST(Upgrade, SnakeCase) {
    EXPECT_EQ(mitsuba::snakeCase("toWorld"), "to_world");
    EXPECT_EQ(mitsuba::snakeCase("intIOR"), "int_ior");
    EXPECT_EQ(mitsuba::snakeCase("extIOR"), "ext_ior");
    EXPECT_EQ(mitsuba::snakeCase("rrDepth"), "rr_depth");
    EXPECT_EQ(mitsuba::snakeCase("diffuseReflectance"), "diffuse_reflectance");
    EXPECT_EQ(mitsuba::snakeCase("alphaU"), "alpha_u");
    EXPECT_EQ(mitsuba::snakeCase("flipTexCoords"), "flip_tex_coords");
    EXPECT_EQ(mitsuba::snakeCase("B"), "B");
    EXPECT_EQ(mitsuba::snakeCase("already_snake"), "already_snake");
    EXPECT_EQ(mitsuba::snakeCase(""), "");
}

TEST(Upgrade, OldSceneEqualsItsTwin) {
    const auto old = parseText(scene(R"(
        <integrator type="path"><integer name="maxDepth" value="9"/><integer name="rrDepth" value="4"/>
            <boolean name="hideEmitters" value="true"/></integrator>
        <sensor type="thinlens"><float name="apertureRadius" value="0.1"/><float name="focusDistance" value="3"/>
            <string name="fovAxis" value="smaller"/><float name="fov" value="40"/><float name="nearClip" value="1"/>
            <transform name="toWorld"><lookAt origin="0,0,-5" target="0,0,0" up="0,1,0"/></transform>
            <sampler type="halton"><integer name="sampleCount" value="16"/><integer name="scramble" value="3"/></sampler>
            <film type="ldrfilm"><integer name="width" value="64"/><string name="pixelFormat" value="rgb"/>
                <boolean name="banner" value="false"/><string name="filename" value="x.png"/>
                <rfilter type="mitchell"><float name="B" value="0.2"/></rfilter></film></sensor>
        <bsdf type="diffuse" id="d"><texture name="diffuseReflectance" type="bitmap">
            <string name="filename" value="w.jpg"/><float name="uscale" value="2"/><float name="voffset" value="0.5"/>
            <string name="filterType" value="ewa"/><float name="gamma" value="1"/>
            <float name="maxAnisotropy" value="8"/></texture></bsdf>
        <bsdf type="dielectric" id="g"><float name="intIOR" value="1.8"/><string name="extIOR" value="air"/>
            <rgb name="specularTransmittance" value="0.9"/></bsdf>
        <shape type="obj"><string name="filename" value="a.obj"/><boolean name="faceNormals" value="true"/>
            <transform name="toWorld"><scale value="2"/></transform><ref id="d"/>
            <emitter type="area"><spectrum name="radiance" value="400:1, 700:2"/></emitter></shape>
        <emitter type="spot"><float name="cutoffAngle" value="30"/><float name="beamWidth" value="20"/></emitter>)",
                                     "0.6.0"));
    const auto twin = parseText(scene(R"(
        <integrator type="path"><integer name="max_depth" value="9"/><integer name="rr_depth" value="4"/>
            <boolean name="hide_emitters" value="true"/></integrator>
        <sensor type="thinlens"><float name="aperture_radius" value="0.1"/><float name="focus_distance" value="3"/>
            <string name="fov_axis" value="smaller"/><float name="fov" value="40"/><float name="near_clip" value="1"/>
            <transform name="to_world"><lookat origin="0,0,-5" target="0,0,0" up="0,1,0"/></transform>
            <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
            <film type="hdrfilm"><integer name="width" value="64"/><string name="pixel_format" value="rgb"/>
                <rfilter type="mitchell"><float name="B" value="0.2"/></rfilter></film></sensor>
        <bsdf type="diffuse" id="d"><texture name="reflectance" type="bitmap">
            <string name="filename" value="w.jpg"/><string name="filter_type" value="bilinear"/>
            <boolean name="raw" value="true"/>
            <transform name="to_uv"><translate y="0.5"/><scale x="2"/></transform></texture></bsdf>
        <bsdf type="dielectric" id="g"><float name="int_ior" value="1.8"/><string name="ext_ior" value="air"/>
            <rgb name="specular_transmittance" value="0.9"/></bsdf>
        <shape type="obj"><string name="filename" value="a.obj"/><boolean name="face_normals" value="true"/>
            <transform name="to_world"><scale value="2"/></transform><ref id="d"/>
            <emitter type="area"><spectrum name="radiance" value="400:1, 700:2"/></emitter></shape>
        <emitter type="spot"><float name="cutoff_angle" value="30"/><float name="beam_width" value="20"/></emitter>)"));
    expectSame(*old.root, *twin.root);
    EXPECT_TRUE(twin.warnings.empty());
    EXPECT_EQ(old.warnings.size(), 5u);  // types of sampler and film, properties of both, anisotropy
    for (const std::string& warning : old.warnings)
        EXPECT_THAT(warning, testing::HasSubstr("scene.xml:")) << warning;
}

TEST(Upgrade, ScenesOfBefore04EqualTheirTwins) {
    const auto old = parseText(scene(R"(
        <camera type="perspective"><float name="fov" value="40"/><boolean name="mapSmallerSide" value="false"/>
            <transform name="toWorld"><translate z="5"/></transform>
            <film type="exrfilm"><integer name="width" value="64"/><boolean name="alpha" value="false"/></film></camera>
        <bsdf type="lambertian" id="d"/><bsdf type="mirror"/>
        <bsdf type="roughmetal"><float name="alphaB" value="0.3"/></bsdf>
        <luminaire type="directional"><rgb name="intensity" value="3"/></luminaire>
        <shape type="cylinder"><point name="p1" value="1 2 3"/><point name="p2" value="4 5 6"/>
            <luminaire type="area"><rgb name="intensity" value="2"/></luminaire></shape>)",
                                     "0.2.0"));
    const auto twin = parseText(scene(R"(
        <sensor type="perspective"><float name="fov" value="40"/>
            <transform name="to_world"><scale x="-1"/><translate z="5"/></transform>
            <film type="hdrfilm"><integer name="width" value="64"/></film>
            <string name="fov_axis" value="larger"/></sensor>
        <bsdf type="diffuse" id="d"/><bsdf type="conductor"><string name="material" value="Cr"/></bsdf>
        <bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf>
        <emitter type="directional"><rgb name="irradiance" value="3"/></emitter>
        <shape type="cylinder"><point name="p0" value="1 2 3"/><point name="p1" value="4 5 6"/>
            <emitter type="area"><rgb name="radiance" value="2"/></emitter></shape>)"));
    expectSame(*old.root, *twin.root);
    EXPECT_THAT(test::errorOf([] { parseText(scene("<camera type=\"perspective\"/>", "0.5.0")); }),
                testing::HasSubstr("<camera"));
}

TEST(Upgrade, NewScenesKeepTheirNames) {
    const auto parsed =
        parseText(scene("<bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"1.8\"/></bsdf>"));
    EXPECT_TRUE(parsed.root->childrenOf("bsdf").at(0)->has("intIOR"));
}

TEST(Upgrade, OfANameInBothSpellingsThatOf06Holds) {
    const std::string text = scene(
        "<bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"1.8\"/>\n"
        "<float name=\"int_ior\" value=\"1.5\"/></bsdf>",
        "0.5.0");
    const auto parsed = parseText(text);
    EXPECT_EQ(parsed.root->childrenOf("bsdf").at(0)->number("int_ior", 0), 1.8f);
    EXPECT_THAT(parsed.warnings, testing::ElementsAre(testing::AllOf(testing::HasSubstr("scene.xml:3"),
                                                                     testing::HasSubstr("int_ior"))));
}

TEST(Upgrade, LeftoversAreUnknownInNewScenes) {
    EXPECT_EQ(parseText(scene("<mode type=\"final\"/>", "0.5.0")).warnings.size(), 1u);
    EXPECT_THAT(test::errorOf([] { parseText(scene("<mode type=\"final\"/>")); }),
                testing::HasSubstr("<mode"));
}

}  // namespace
}  // namespace metrolux::core
