/// Media of pbrt scenes.

#include "io/mitsuba/xml_writer.h"
#include "media_support.h"
#include "pbrt_support.h"

#include <gmock/gmock.h>

#include <numbers>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const std::string kLight = "LightSource \"infinite\"\n";

/// The medium in a sphere.
MediumPtr medium(const std::string& parameters, const LoadOptions& options = {}) {
    const SceneParts parts = loadedPbrt(
        pbrtScene("MakeNamedMedium \"m\" " + parameters +
                  "\nMediumInterface \"m\" \"\"\nMaterial \"interface\"\nShape \"sphere\"\n" + kLight),
        options);
    return parts.media.at(0);
}
std::string error(const std::string& parameters) {
    return errorOf([&] { medium(parameters); });
}

TEST(PbrtMedia, Homogeneous) {
    const std::string type = "\"string type\" \"homogeneous\" ";
    expectMedium(*medium(type), Rgb(2.0f), Rgb(0.5f));
    const MediumPtr fog = medium(
        type +
        R"("rgb sigma_a" [1 2 3] "rgb sigma_s" [3 2 0] "float scale" 10 "float g" 0.5 "rgb Le" [0 0 0])");
    expectMedium(*fog, {40, 40, 30}, {0.75f, 0.5f, 0});
    EXPECT_NEAR(fog->phase().evaluate(Vec3f(0.0f), 1), 0.75f / 0.125f / (4 * std::numbers::pi_v<float>),
                1e-4);
    const MediumPtr skin = medium(type + "\"string preset\" \"Skin1\"");
    expectNear(skin->scattering(Vec3f(0.0f)), {0.74f, 0.88f, 1.01f});
    const MediumPtr milk = medium(type + "\"string preset\" \"Regular Milk\" \"float scale\" 1000");
    expectNear(milk->scattering(Vec3f(0.0f)), {4551.3f, 5829.4f, 7136});
}

TEST(PbrtMedia, AGridFallsToZeroAtItsFaces) {
    const MediumPtr grid = medium(
        R"("string type" "uniformgrid" "integer nx" 2 "integer ny" 1 "integer nz" 1 "float density" [1 3]
        "rgb sigma_a" [1 1 1] "rgb sigma_s" [1 1 1] "float scale" 2 "point3 p0" [0 0 0] "point3 p1" [4 1 1])");
    expectMedium(*grid, Rgb(4.0f), Rgb(0.5f), {1, 0.5f, 0.5f});
    expectMedium(*grid, Rgb(8.0f), Rgb(0.5f), {2, 0.5f, 0.5f});
    expectMedium(*grid, Rgb(2.0f), Rgb(0.5f), {0, 0.5f, 0.5f});
    expectMedium(*grid, Rgb(6.0f), Rgb(0.5f), {3, 0.5f, 0});
    const MediumPtr colored = medium(
        R"("string type" "uniformgrid" "float density" 2 "rgb sigma_a" [1 0 0] "rgb sigma_s" [1 2 0])");
    expectMedium(*colored, {4, 4, 0}, {0.5f, 1, 0}, {0.5f, 0.5f, 0.5f});
}

TEST(PbrtMedia, SidesAndPlaces) {
    const SceneParts parts = loadedPbrt(pbrtScene(R"(
LightSource "point"
MakeNamedMedium "milk" "string type" "homogeneous" "rgb sigma_a" [7 7 7]
AttributeBegin
MediumInterface "milk" "fog"
Material "dielectric" Shape "sphere"
ReverseOrientation Shape "sphere"
AttributeEnd
Shape "sphere"
MediumInterface ""
Shape "sphere"
LightSource "point"
)",
                                                  "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\n"
                                                  "MediumInterface \"\" \"fog\"\n"));
    ASSERT_EQ(parts.media.size(), 2u);
    const MediumIndex fog = parts.media[0]->extinction(Vec3f(0.0f)).x == 2 ? 1 : 2,
                      milk = static_cast<MediumIndex>(3 - fog);
    EXPECT_EQ(parts.camera->medium, fog);
    EXPECT_EQ(parts.lights.at(0)->medium, fog);
    EXPECT_EQ(parts.lights.at(1)->medium, std::nullopt);
    for (const size_t i : {0u, 1u}) {
        ASSERT_TRUE(parts.shapes.at(i)->media);
        EXPECT_EQ(parts.shapes[i]->media->interior, milk);
        EXPECT_EQ(parts.shapes[i]->media->exterior, fog);
    }
    ASSERT_TRUE(parts.shapes.at(2)->media);
    EXPECT_EQ(parts.shapes[2]->media->interior, 0);
    EXPECT_EQ(parts.shapes[2]->media->exterior, fog);
    EXPECT_FALSE(parts.shapes.at(3)->media);
    EXPECT_THAT(parts.warnings, IsEmpty());
}

TEST(PbrtMedia, ABackIsTurnedAround) {
    const SceneParts parts = loadedPbrt(pbrtScene(
        "MakeNamedMedium \"in\" \"string type\" \"homogeneous\" MakeNamedMedium \"out\" \"string type\" "
        "\"homogeneous\"\nMediumInterface \"in\" \"out\" AreaLightSource \"diffuse\" \"bool twosided\" true "
        "Shape \"sphere\""));
    ASSERT_EQ(parts.shapes.size(), 2u);
    const MediumSides front = parts.shapes[0]->media.value(), back = parts.shapes[1]->media.value();
    EXPECT_NE(front.interior, front.exterior);
    EXPECT_EQ(back.exterior, front.interior);
    EXPECT_EQ(back.interior, front.interior);
}

TEST(PbrtMedia, RefusalsNameTheirPlace) {
    EXPECT_THAT(error("\"string type\" \"cloud\""),
                HasSubstr("scene.pbrt:6: MakeNamedMedium \"m\": the medium \"cloud\""));
    EXPECT_THAT(error("\"string type\" \"homogenous\""), HasSubstr("did you mean \"homogeneous\"?"));
    EXPECT_THAT(error("\"float g\" 0"), HasSubstr("\"string type\""));
    EXPECT_THAT(error("\"string type\" \"homogeneous\" \"float sigma_a\" -1"), HasSubstr("found -1"));
    EXPECT_THAT(error("\"string type\" \"homogeneous\" \"rgb Le\" [1 0 0]"), HasSubstr("emissive"));
    EXPECT_THAT(error("\"string type\" \"homogeneous\" \"float g\" 1"), HasSubstr("g is 1"));
    EXPECT_THAT(error("\"string type\" \"homogeneous\" \"string preset\" \"Skin3\""), HasSubstr("Skin3"));
    EXPECT_THAT(error("\"string type\" \"uniformgrid\" \"integer nx\" 2 \"float density\" [1]"),
                HasSubstr("found 1 values of \"density\", expected 2 x 1 x 1"));
    EXPECT_THAT(error("\"string type\" \"uniformgrid\" \"integer nx\" -2 \"float density\" [1]"),
                HasSubstr("nx -2"));
    EXPECT_THAT(error("\"string type\" \"uniformgrid\" \"float density\" [-1]"), HasSubstr("scene.pbrt:6"));
    EXPECT_THAT(
        error("\"string type\" \"homogeneous\" MakeNamedMedium \"m\" \"string type\" \"homogeneous\""),
        HasSubstr("a second time"));
    LoadOptions lenient;
    lenient.lenient = true;
    EXPECT_NO_THROW(medium("\"string type\" \"homogeneous\" \"blackbody Le\" 3000", lenient));
}

TEST(PbrtMedia, ConvertedTheyAreTheSame) {
    const TemporaryFolder folder;
    const auto file = folder.write("scene.pbrt", pbrtScene(kLight + R"(Rotate 30 0 0 1 Scale 1 2 3
MakeNamedMedium "m" "string type" "uniformgrid" "integer nx" 2 "float density" [1 3] "rgb sigma_a" [1 0.5 0]
MediumInterface "m" "" Material "interface" Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0])"));
    const auto out = folder.path() / "out.xml";
    mitsuba::writeScene(parseSceneFile(file, {}), out);
    const SceneParts before = loadScene(file, {}), after = loadScene(out, {});
    ASSERT_EQ(after.media.size(), 1u);
    EXPECT_EQ(after.shapes.at(0)->media->interior, 1);
    for (const float x : {0.1f, 0.4f}) {
        const Vec3f p(x, 0.9f, 1.3f);
        EXPECT_GT(before.media[0]->extinction(p).x, 0);
        EXPECT_EQ(after.media[0]->extinction(p), before.media[0]->extinction(p));
        EXPECT_EQ(after.media[0]->scattering(p), before.media[0]->scattering(p));
    }
}

}  // namespace
}  // namespace metrolux::core::test
