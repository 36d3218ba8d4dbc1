/// pbrt's textures by position: mappings, noise, cubes and discs, and what is combined where a ray hits.

#include "geometry/shape.h"
#include "io/mitsuba/xml_writer.h"
#include "pbrt_support.h"
#include "scattering/textures/constant.h"
#include "scattering/textures/gradient_noise.h"
#include "scattering/textures/positional.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;

/// Black and white squares, two a row; `texture` is called "t", a point at the origin is seen.
Rgb seen(const std::string& texture) {
    return seenPbrt(pbrtScene("LightSource \"infinite\"\n" + texture +
                              "\nIdentity Material \"diffuse\" \"texture reflectance\" \"t\"\n" + kQuad),
                    50);
}
const std::string kBoard =
    R"(Texture "t" "spectrum" "checkerboard" "rgb tex1" [0.9 0 0] "rgb tex2" [0 0.9 0] )";
const Rgb kFirst{0.9f, 0, 0}, kSecond{0, 0.9f, 0};

TEST(PbrtTextures, PlanarMappingsAreOfTheWorld) {
    const auto at = [](const std::string& before, const std::string& more = "") {
        return seen("AttributeBegin " + before + kBoard + "\"string mapping\" \"planar\" " + more +
                    " AttributeEnd");
    };
    expectColor(at("Translate -0.25 -0.5 0 "), kFirst);  // (0.25, 0.5)
    expectColor(at("Translate 0.25 -0.5 0 "), kSecond);  // (-0.25, 0.5)
    expectColor(at("Translate 0.25 0.5 0 "), kFirst);    // (-0.25, -0.5)
    expectColor(at("Translate -0.25 -0.5 0 ", "\"float udelta\" 1"), kSecond);
    expectColor(at("Translate -0.25 -0.5 0 ", "\"vector3 v1\" [8 0 0] \"float udelta\" -0.5"),
                kSecond);  // 1.5
    expectColor(at("Scale 0.1 1 1 Translate -1.5 -0.5 0 "), kSecond);
}

TEST(PbrtTextures, SphericalAndCylindricalMappingsHavePbrtsAngles) {
    // Rows of eight from below: 0 to 7 tenths.
    ImageData rows{2, 8, 3, {}};
    for (int y = 0; y < 8; ++y) rows.pixels.insert(rows.pixels.end(), 6, static_cast<float>(7 - y) / 10);
    const auto at = [&](const std::string& mapping, const std::string& before) {
        return seenWithImage(
            rows,
            pbrtScene("LightSource \"infinite\"\nAttributeBegin " + before +
                      " Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"image.png\" \"string "
                      "encoding\" \"linear\" \"string filter\" \"point\" \"string mapping\" \"" +
                      mapping + "\" AttributeEnd\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n" +
                      kQuad),
            50);
    };
    const auto expectRow = [](const Rgb& color, int row) {
        EXPECT_NEAR(color.x, static_cast<float>(row) / 10, 0.01f);
    };
    // t is the angle around z over a turn: 60 and 300 degrees, 1.33 and 6.67 rows.
    expectRow(at("spherical", "Translate -0.5 -0.866 0"), 1);
    expectRow(at("spherical", "Translate -0.5 0.866 0"), 6);
    // t is z.
    expectRow(at("cylindrical", "Translate -1 0 -0.3"), 2);
    expectRow(at("cylindrical", "Translate -1 0 -0.8"), 6);
}

TEST(PbrtTextures, CubesFillSpace) {
    const auto at = [](const std::string& before) {
        return seen("AttributeBegin " + before + kBoard + "\"integer dimension\" 3 AttributeEnd");
    };
    expectColor(at("Translate -0.5 -0.5 -0.5 "), kFirst);
    expectColor(at("Translate 0.5 -0.5 -0.5 "), kSecond);
    expectColor(at("Translate 0.5 0.5 -0.5 "), kFirst);
    expectColor(at("Translate 0.5 0.5 0.5 "), kSecond);
}

TEST(PbrtTextures, DotsHaveDiscsInSomeSquares) {
    const TexturePtr dots = makeCells({CellsParameters::Kind::Discs, makeConstantTexture(Rgb(1.0f)),
                                       makeConstantTexture(Rgb(0.0f)), Transform()});
    double sum = 0;
    constexpr int kSquares = 200, kSteps = 20;
    SurfaceInteraction si;
    for (int i = 0; i < kSquares * kSteps; ++i)
        for (int j = 0; j < 20 * kSteps; ++j) {
            si.uv = {(static_cast<float>(i) + 0.5f) / kSteps, (static_cast<float>(j) + 0.5f) / kSteps};
            sum += double(dots->scalar(si));
            const Vec2f inSquare(si.uv.x - std::round(si.uv.x), si.uv.y - std::round(si.uv.y));
            // Discs stay within their squares.
            if (std::max(std::abs(inSquare.x), std::abs(inSquare.y)) > 0.49f) {
                EXPECT_EQ(dots->scalar(si), 0);
            }
        }
    EXPECT_NEAR(sum / (double(kSquares) * 20 * kSteps * kSteps), double(dots->mean().x), 0.01);
}

/// Values of a program in another language, by the definition.
TEST(GradientNoise, HasItsValues) {
    EXPECT_NEAR(gradientNoise({0.3f, 0.4f, 0.7f}), -0.0597669f, 1e-6f);
    EXPECT_NEAR(gradientNoise({-1.25f, 7.5f, 100.1f}), -0.2002246f, 1e-5f);
    EXPECT_NEAR(gradientNoise({300.2f, -40.7f, 3.3f}), 0.1709865f, 1e-4f);
    EXPECT_EQ(gradientNoise({3, -4, 5}), 0);
    EXPECT_EQ(gradientNoise({1e30f, 0.5f, 0.5f}), 0);
    EXPECT_NEAR(turbulence({0.3f, 0.4f, 0.7f}, 0.5f, 8), 0.2957526f, 1e-5f);
    EXPECT_NEAR(fractalNoise({0.3f, 0.4f, 0.7f}, 0.5f, 8), 0.0113527f, 1e-5f);
    EXPECT_NEAR(fractalNoise({1.2f, 3.4f, -0.6f}, 0.6f, 4), 0.1830311f, 1e-5f);
}

TEST(PbrtTextures, NoiseIsThatOfThePlace) {
    const auto at = [](const std::string& texture) {
        return seen("AttributeBegin Translate -0.3 -0.4 -0.7 Texture \"t\" \"spectrum\" " + texture +
                    " AttributeEnd");
    };
    expectGray(at("\"wrinkled\" \"integer octaves\" 4"), turbulence({0.3f, 0.4f, 0.7f}, 0.5f, 4));
    expectGray(at("\"fbm\" \"integer octaves\" 1"), 0);  // a negative reflectance
    const float fractal = fractalNoise({0.3f, 0.4f, 0.7f}, 0.9f, 3);
    EXPECT_NEAR(at("\"fbm\" \"integer octaves\" 3 \"float roughness\" 0.9").x, std::max(fractal, 0.0f),
                0.001f);
    const Rgb windy = at("\"windy\"");
    const Vec3f p(0.3f, 0.4f, 0.7f);
    EXPECT_NEAR(windy.x, std::max(0.0f, std::abs(fractalNoise(p * 0.1f, 0.5f, 3)) * fractalNoise(p, 0.5f, 6)),
                0.0005f);
    // Without variation the marble is a sine of y: at 0.4 it is at t = 0.694712, the middle of the spline.
    const float t = 6 * (0.5f + 0.5f * std::sin(0.4f)) - 4, r = 1 - t;
    const auto spline = [&](float a, float b, float c, float d) {
        return 1.5f * (r * r * r * a + 3 * r * r * t * b + 3 * r * t * t * c + t * t * t * d);
    };
    expectColor(at("\"marble\" \"float variation\" 0"),
                {spline(.6f, .58f, .58f, .2f), spline(.59f, .58f, .58f, .2f), spline(.58f, .6f, .6f, .33f)});
    // As an amount.
    expectColor(
        seen("AttributeBegin Translate -0.3 -0.4 -0.7 Texture \"w\" \"float\" \"wrinkled\" AttributeEnd\n"
             "Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 1 0] \"texture "
             "amount\" \"w\""),
        {1 - 0.29575f, 0.29575f, 0});
}

TEST(PbrtTextures, WhatLiesOnTheSurfaceInTwoWaysIsCombinedThere) {
    const float noise = turbulence({0.3f, 0.4f, 0.7f}, 0.5f, 3);
    const std::string two = R"(AttributeBegin Translate -0.25 -0.5 0
Texture "a" "spectrum" "checkerboard" "rgb tex1" [0.8 0.6 0.4] "rgb tex2" [0 0 0] "string mapping" "planar"
Translate -0.05 0.1 -0.7
Texture "b" "spectrum" "wrinkled" "integer octaves" 3 AttributeEnd
Texture "i" "spectrum" "scale" "texture tex" "b" "float scale" 0.5
)";
    expectColor(seen(two + R"(Texture "t" "spectrum" "scale" "texture tex" "a" "texture scale" "b")"),
                {0.8f * noise, 0.6f * noise, 0.4f * noise});
    // Half of one and half of the other, which is a product of two kinds of noise.
    const std::string product = R"(Texture "p" "spectrum" "scale" "texture tex" "b" "texture scale" "i"
)";
    expectColor(seen(two + product + R"(Texture "t" "spectrum" "mix" "texture tex1" "a" "texture tex2" "b")"),
                {0.4f + 0.5f * noise, 0.3f + 0.5f * noise, 0.2f + 0.5f * noise});
    expectGray(
        seen(two + product + R"(Texture "t" "spectrum" "scale" "texture tex" "p" "texture scale" "b")"),
        0.5f * noise * noise * noise);
    EXPECT_THAT(errorOf([&] {
                    loadedPbrt(pbrtScene("LightSource \"infinite\"\n" + two + product +
                                         "Material \"conductor\" \"texture roughness\" \"p\"\n" + kQuad));
                }),
                HasSubstr("different ways"));
}

TEST(PbrtTextures, BumpsOfNoiseHaveItsSlope) {
    NoiseTextureParameters p;
    p.octaves = 1;
    p.low = -1;
    p.high = 1;
    p.colors = {Rgb(-1.0f), Rgb(1.0f)};
    const TexturePtr noise = makeNoiseTexture(p);
    const ShapePtr quad = makeRectangle(Transform::translate({0.3, 0.4, 0.7}), false);
    SurfaceInteraction si;
    si.p = {0.3f, 0.4f, 0.7f};
    si.uv = {0.5f, 0.5f};
    si.ns = si.ng = {0, 0, 1};
    si.s = {1, 0, 0};
    si.shape = quad.get();
    const Vec2f gradient = noise->gradient(si);
    constexpr float h = 1e-3f;
    const auto slope = [&](const Vec3f& d) {
        return (gradientNoise(si.p + d) - gradientNoise(si.p - d)) / (2 * h) * 2;
    };
    EXPECT_NEAR(gradient.x, slope({h, 0, 0}), 5e-3f);  // the quad is two wide
    EXPECT_NEAR(gradient.y, slope({0, h, 0}), 5e-3f);
}

TEST(PbrtTextures, ConvertedOnesKeepTheirBits) {
    const TemporaryFolder folder;
    ImageData image{2, 2, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}};
    folder.write("image.png", encodePngRaw(image));
    const auto file = folder.write("room.pbrt", R"(LookAt 0 0 3  0 0 0  0 1 0
Camera "perspective" "float fov" 40
Film "rgb" "integer xresolution" 16 "integer yresolution" 12
WorldBegin
LightSource "infinite"
AttributeBegin Rotate 30 1 2 3
Texture "a" "spectrum" "imagemap" "string filename" "image.png" "string mapping" "spherical"
Texture "b" "spectrum" "marble" "float scale" 7
Texture "c" "spectrum" "checkerboard" "integer dimension" 3 "texture tex1" "a" "texture tex2" "b"
Texture "d" "spectrum" "dots" "string mapping" "planar" "vector3 v1" [5 0 0] "vector3 v2" [0 5 0] "texture inside" "c" "rgb outside" [0.3 0.3 0.3]
Texture "w" "float" "wrinkled"
Texture "e" "spectrum" "scale" "texture tex" "b" "texture scale" "a"
Texture "f" "spectrum" "mix" "texture tex1" "d" "texture tex2" "e" "texture amount" "w"
AttributeEnd
Material "diffuse" "texture reflectance" "f" "texture displacement" "w"
)" + kQuad + "Translate 0.2 0.3 0.4 Shape \"sphere\" \"float radius\" 0.3\n");
    const auto out = folder.path() / "room.xml";
    mitsuba::writeScene(parseSceneFile(file, {}), out);
    EXPECT_EQ(RenderableScene(out, {}).render("vcm", 2, 1), RenderableScene(file, {}).render("vcm", 2, 1));
}

TEST(PbrtTextures, RefuseWhatIsNone) {
    const auto error = [](const std::string& texture) {
        return errorOf([&] {
            loadedPbrt(pbrtScene("LightSource \"infinite\"\n" + texture +
                                 "\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n" + kQuad));
        });
    };
    EXPECT_THAT(error(kBoard + "\"string mapping\" \"conical\""),
                HasSubstr("spherical, cylindrical or planar"));
    EXPECT_THAT(error(kBoard + "\"integer dimension\" 4"), HasSubstr("expected 2 or 3"));
    EXPECT_THAT(error("Texture \"t\" \"spectrum\" \"fbm\" \"integer octaves\" 0"), HasSubstr("0 octaves"));
    EXPECT_THAT(error("Texture \"t\" \"spectrum\" \"fbm\" \"integer octaves\" 9000000000"),
                HasSubstr("octaves"));
    EXPECT_THAT(error("Texture \"t\" \"spectrum\" \"fbm\" \"float scale\" 2"), HasSubstr("float scale"));
    EXPECT_THAT(error("Texture \"t\" \"spectrum\" \"ptex\""), HasSubstr("fbm, wrinkled, windy and marble"));
    std::string deep = "Texture \"t\" \"spectrum\" \"wrinkled\"\n";
    for (int i = 0; i < 12; ++i)
        deep += "Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"texture scale\" \"t\"\n";
    EXPECT_THAT(error(deep), HasSubstr("nested more than"));
    // As XML, which anybody may write.
    const auto xml = [](const std::string& texture) {
        return errorOf([&] {
            const TemporaryFolder folder;
            loadScene(folder.write("scene.xml", underSky(quad(diffuse(texture)))), {});
        });
    };
    EXPECT_THAT(xml(R"(<texture name="reflectance" type="noise"/>)"), HasSubstr("filename"));
    EXPECT_THAT(xml(R"(<texture name="reflectance" type="mapped"/>)"), HasSubstr("nested <texture>"));
    EXPECT_THAT(
        xml(R"(<texture name="reflectance" type="cells"><string name="kind" value="balls"/></texture>)"),
        HasSubstr("cubes, discs"));
    EXPECT_THAT(
        errorOf([] {
            const TemporaryFolder folder;
            loadScene(folder.write("scene.xml", underSky(R"(<shape type="sphere"><emitter type="area"><texture
name="radiance" type="cells"/></emitter></shape>)")),
                      {});
        }),
        HasSubstr("unknown texture"));
}

}  // namespace
}  // namespace metrolux::core::test
