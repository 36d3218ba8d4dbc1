/// pbrt scenes: what directives, lights and shapes become, against closed forms.

#include "pbrt_support.h"

#include <gmock/gmock.h>

#include <numbers>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;

constexpr float kPiF = std::numbers::pi_v<float>;

/// What a matte surface of this reflectance makes of the light.
Rgb onMatte(const std::string& light, const std::string& before = "",
            const std::string& color = "0.5 0.5 0.5") {
    return seenPbrt(
        pbrtScene(light + "\nMaterial \"diffuse\" \"rgb reflectance\" [" + color + "]\n" + kQuad, before));
}

TEST(Pbrt, PointLights) {
    const std::string at = R"(LightSource "point" "point3 from" [0 0 2] )";
    expectColor(onMatte(at + R"("rgb I" [8 4 2])", "", "0.8 0.4 0.2"),
                Rgb(0.8f * 8, 0.4f * 4, 0.2f * 2) / (4 * kPiF));
    expectGray(onMatte(at + R"("float scale" 6)"), 0.5f * 6 / (4 * kPiF));
    expectGray(onMatte(at + R"("float power" 100)"), 0.5f / kPiF * 100 / (4 * kPiF) / 4);
    expectGray(
        onMatte("Translate 0 0 1\nLightSource \"point\" \"point3 from\" [0 0 1] \"float scale\" 6\nIdentity"),
        0.5f * 6 / (4 * kPiF));
}

TEST(Pbrt, ALightsSpectrumHasTheLuminanceOne) {
    const std::string at = R"(LightSource "point" "point3 from" [0 0 2] "float scale" 8 )";
    for (const char* spectrum : {R"("blackbody I" 2700)", R"("spectrum I" [300 7 800 7])",
                                 R"("spectrum I" "stdillum-D65")", R"("spectrum I" [400 0 550 3 700 9])"})
        EXPECT_NEAR(luminance(onMatte(at + spectrum)), 1 / kPiF, 1e-4) << spectrum;
    const Rgb warm = onMatte(at + R"("blackbody I" 2700)");
    EXPECT_GT(warm.x, 1.5f * warm.y);
    EXPECT_GT(warm.y, 1.5f * warm.z);
}

TEST(Pbrt, SpotAndDistantLights) {
    const std::string spot =
        R"(LightSource "spot" "point3 from" [0 0 2] "point3 to" [0 0 0] "float coneangle" 40 )";
    expectGray(onMatte(spot + R"("float scale" 8)"), 1 / kPiF);
    const double inner = std::cos(35 * kPiF / 180), outer = std::cos(40 * kPiF / 180);
    expectGray(onMatte(spot + R"("float power" 10)"),
               static_cast<float>(0.5 / kPiF / 4 * 10 / (2 * kPiF * (1 - inner + (inner - outer) / 2))));
    expectGray(onMatte(R"(LightSource "spot" "point3 from" [0 0 2] "point3 to" [0 0 3])"), 0);
    expectColor(
        onMatte(
            R"(LightSource "distant" "point3 from" [0 0 1] "point3 to" [0 0 0] "rgb L" [1 2 3] "float scale" 2)"),
        Rgb(1, 2, 3) / kPiF);
    expectGray(
        onMatte(R"(LightSource "distant" "point3 from" [1 0 1] "point3 to" [0 0 0] "float illuminance" 3)"),
        0.5f / kPiF * 3 * std::sqrt(0.5f));
}

TEST(Pbrt, InfiniteLights) {
    expectColor(onMatte(R"(LightSource "infinite" "rgb L" [1 2 3] "float scale" 2)"), {1, 2, 3});
    expectGray(onMatte(R"(LightSource "infinite" "float illuminance" 3)"), 0.5f / kPiF * 3);
}

TEST(Pbrt, AnEqualAreaImageLightsFromItsDirections) {
    // 32 x 32, white in its middle: the upper hemisphere is the inner diamond |u| + |v| < 1.
    ImageData image{32, 32, 3, std::vector<float>(32 * 32 * 3)};
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x)
            if (std::abs(x - 15.5f) + std::abs(y - 15.5f) < 16)
                for (int c = 0; c < 3; ++c) image.pixels[static_cast<size_t>(3 * (32 * y + x) + c)] = 1;
    const std::string light = R"(LightSource "infinite" "string filename" "image.png" )";
    const std::string quad = "\nMaterial \"diffuse\"\n" + kQuad;
    EXPECT_NEAR(seenWithImage(image, pbrtScene(light + quad)).x, 0.5, 0.01);
    EXPECT_NEAR(seenWithImage(image, pbrtScene(light + R"("float illuminance" 4)" + quad)).x, 0.5 * 4 / kPiF,
                0.03);
    EXPECT_NEAR(seenWithImage(image, pbrtScene("Rotate 180 1 0 0\n" + light + "\nIdentity\n" + quad)).x, 0,
                0.01);
    // One texel, toward +x, seen by a mirror that turns the view there.
    ImageData one{32, 32, 3, std::vector<float>(32 * 32 * 3)};
    for (int y = 14; y < 18; ++y)  // around (u, v) = (1, 0)
        for (int x = 28; x < 32; ++x) one.pixels[static_cast<size_t>(3 * (32 * y + x))] = 1;
    const std::string mirror =
        "Rotate 45 0 1 0\nMaterial \"conductor\" \"rgb reflectance\" [0.9999 0.9999 0.9999]\n" + kQuad;
    expectColor(seenWithImage(one, pbrtScene(light + mirror), 20), {1, 0, 0});
    expectColor(seenWithImage(one, pbrtScene("Rotate 90 0 0 1\n" + light + "\nIdentity\n" + mirror), 20),
                {0, 0, 0});
}

TEST(Pbrt, AnImageShapesTheIntensityOfAGoniometricLight) {
    // White over the half of the directions with y > 0 (pbrt's image has y and z exchanged).
    ImageData image{32, 32, 3, std::vector<float>(32 * 32 * 3)};
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x)
            if (std::abs(x - 15.5f) + std::abs(y - 15.5f) < 16)
                for (int c = 0; c < 3; ++c) image.pixels[static_cast<size_t>(3 * (32 * y + x) + c)] = 1;
    const auto lit = [&](const std::string& turn, const std::string& more) {
        return seenWithImage(image,
                             pbrtScene("Translate 0 0 2\n" + turn +
                                       "\nLightSource \"goniometric\" \"string filename\" \"image.png\" " +
                                       more + "\nIdentity\nMaterial \"diffuse\"\n" + kQuad),
                             20);
    };
    expectGray(lit("Rotate -90 1 0 0", "\"float scale\" 8"), 1 / kPiF);  // its y downward
    expectGray(lit("Rotate 90 1 0 0", "\"float scale\" 8"), 0);
    EXPECT_NEAR(lit("Rotate -90 1 0 0", "\"float power\" 100").x, 0.5f / kPiF / 4 * 100 / (2 * kPiF), 0.02);
}

TEST(Pbrt, AreaLights) {
    const std::string lamp = R"(AreaLightSource "diffuse" "rgb L" [3 2 1] "float scale" 2 )";
    const std::string behind = "0 0 -3";
    expectColor(seenPbrt(pbrtScene(lamp + kQuad)), {6, 4, 2});
    expectGray(seenPbrt(pbrtScene(lamp + kQuad, "", behind)), 0);
    expectColor(seenPbrt(pbrtScene("ReverseOrientation\n" + lamp + kQuad, "", behind)), {6, 4, 2});
    expectColor(seenPbrt(pbrtScene(lamp + "\nScale -1 1 1\n" + kQuad)), {6, 4, 2});  // mirrored
    for (const char* eye : {"0 0 3", "0 0 -3"})
        for (const std::string& shape :
             {kQuad, std::string("Shape \"disk\"\n"), std::string("Shape \"sphere\"\n")})
            expectColor(seenPbrt(pbrtScene(lamp + R"("bool twosided" true )" + shape, "", eye)), {6, 4, 2});
    // pbrt's power is that of each triangle: 2 of 2 square units each.
    expectGray(seenPbrt(pbrtScene(R"(AreaLightSource "diffuse" "float power" 10 )" + kQuad)),
               10 / (2 * kPiF));
    expectGray(seenPbrt(pbrtScene("Scale 2 2 2\nAreaLightSource \"diffuse\" \"float power\" 10 Shape "
                                  "\"sphere\" \"float radius\" 0.5")),
               10 / (kPiF * 4 * kPiF));
}

TEST(Pbrt, TheFilmsSensorMultipliesLight) {
    expectGray(
        seenPbrt(
            "LookAt 0 0 3 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" 1 \"float shutterclose\" 0.5\n"
            "Film \"rgb\" \"float iso\" 400 \"integer xresolution\" 16 \"integer yresolution\" "
            "12\nWorldBegin\n"
            "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n" +
            kQuad),
        2);
}

TEST(Pbrt, MapsAreMultipliedFromTheRight) {
    const std::string lamp = R"(AreaLightSource "diffuse" )";
    const auto isSeen = [&](const std::string& maps) {
        return seenPbrt(pbrtScene(lamp + maps + kQuad), 1).x > 0.5f;
    };
    EXPECT_TRUE(isSeen("Translate 2 0 0 Translate -2 0 0\n"));
    EXPECT_FALSE(isSeen("Translate 2 0 0 Scale 0.5 0.5 0.5\n"));
    EXPECT_TRUE(isSeen("Scale 0.5 0.5 0.5 Translate 1 0 0\n"));
    EXPECT_FALSE(isSeen("Rotate 180 0 1 0\n"));
    EXPECT_TRUE(isSeen("Rotate 90 0 0 1 Translate 0 -0.9 0\n"));  // to +x: (0, -0.9) becomes (0.9, 0)
    EXPECT_TRUE(isSeen("Transform [1 0 0 0  0 1 0 0  0 0 1 0  0.9 0 0 1]\n"));
    EXPECT_FALSE(isSeen("Transform [1 0 0 0  0 1 0 0  0 0 1 0  1.1 0 0 1]\n"));
    EXPECT_FALSE(isSeen("Translate 1 0 0 ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 0  1 0 0 1]\n"));
    EXPECT_TRUE(isSeen("CoordinateSystem \"here\" Translate 5 0 0 CoordSysTransform \"here\"\n"));
    EXPECT_TRUE(isSeen("AttributeBegin Translate 5 0 0 AttributeEnd\n"));
    EXPECT_TRUE(isSeen("TransformBegin Translate 5 0 0 TransformEnd\n"));
    // The lamp hangs before the camera.
    EXPECT_FALSE(isSeen("CoordSysTransform \"camera\" Translate 0 0 2\n"));  // away from it
    EXPECT_TRUE(isSeen("CoordSysTransform \"camera\" Translate 0 0 2 Rotate 180 0 1 0\n"));
}

TEST(Pbrt, ObjectsAreInstanced) {
    const std::string object =
        "LightSource \"infinite\"\nObjectBegin \"o\"\nMaterial \"diffuse\" \"rgb reflectance\" [0.3 0.6 "
        "0.9]\n"
        "Translate 0 2 0\n" +
        kQuad + "ObjectEnd\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n";
    expectGray(seenPbrt(pbrtScene(object)), 1);
    expectColor(seenPbrt(pbrtScene(object + "Translate 0 -2 0\nObjectInstance \"o\"\n")), {0.3f, 0.6f, 0.9f});
    EXPECT_EQ(loadedPbrt(pbrtScene(object + "ObjectInstance \"o\" Scale 2 2 2 ObjectInstance \"o\""))
                  .instances.size(),
              2u);
}

TEST(Pbrt, FilesAreIncluded) {
    const TemporaryFolder folder;
    folder.write("more/quad.pbrt", "Include \"lamp.pbrt\"\n" + kQuad);
    folder.write("more/lamp.pbrt", "AreaLightSource \"diffuse\" \"rgb L\" [5 5 5]\n");
    std::vector<std::filesystem::path> files;
    const auto file = folder.write("scene.pbrt", pbrtScene("Include \"more/quad.pbrt\"\n"));
    loadScene(file, {}, &files);
    EXPECT_EQ(files.size(), 3u);
    expectGray(meanOf(RenderableScene(file, {}).render("path", 4, 1)), 5);
    folder.write("more/lamp.pbrt", "\nAreaLightSource \"diffuse\" \"rgb L\" [5 5 what]\n");
    EXPECT_THAT(errorOf([&] { loadScene(file, {}); }), HasSubstr("more/lamp.pbrt:2: found what"));
    folder.write("more/lamp.pbrt", "Include \"quad.pbrt\"\n");
    EXPECT_THAT(errorOf([&] { loadScene(file, {}); }), HasSubstr("include each other"));
}

TEST(Pbrt, Shapes) {
    const auto radiance = [](const std::string& shape, const std::string& eye = "0 0 3") {
        return seenPbrt(pbrtScene(
                            "AreaLightSource \"diffuse\" Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n" +
                                shape,
                            "", eye),
                        4)
            .x;
    };
    for (const char* shape : {"Shape \"sphere\" \"float radius\" 0.5", "Scale 1 2 1 Shape \"sphere\"",
                              "Shape \"sphere\" \"float zmin\" 0.5",
                              "Translate -0.2 -0.2 0 Shape \"sphere\" \"float phimax\" 90 \"float zmin\" 0.2",
                              "Shape \"disk\" \"float height\" 1", "Rotate 90 1 0 0 Shape \"cylinder\"",
                              "Rotate 90 1 0 0 Rotate 45 0 0 1 Shape \"cylinder\" \"float phimax\" 180",
                              "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0] "
                              "\"integer indices\" [0 1 2 3]",
                              "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0  1 -1 0.5  -1 1 0.5  1 1 0]",
                              "Shape \"loopsubdiv\" \"integer levels\" 3 \"point3 P\" [-1 -1 0  1 -1 0  0 1 "
                              "0] \"integer indices\" [0 1 2]"}) {
        EXPECT_FLOAT_EQ(radiance(shape), 1) << shape;
    }
    // From behind, or through what is left out.
    for (const char* shape :
         {"Shape \"disk\" \"float innerradius\" 0.5", "Shape \"sphere\" \"float zmax\" 0.5",
          "ReverseOrientation Shape \"disk\"", "ReverseOrientation Shape \"sphere\""})
        EXPECT_EQ(radiance(shape), 0) << shape;
    EXPECT_FLOAT_EQ(radiance("ReverseOrientation Shape \"sphere\" \"float radius\" 5"), 1);
    EXPECT_FLOAT_EQ(radiance("Shape \"sphere\" \"float zmax\" 0.5", "0 0 -3"), 1);
}

TEST(Pbrt, PlyMeshesWithoutNormalsAreFlat) {
    const TemporaryFolder folder;
    // A ridge: smoothed normals would tilt the light that the left face gets.
    folder.write(
        "mesh.ply",
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "-2 -1 0\n1 -1 0\n1 1 0\n-2 1 0\n3 0 1 2\n3 0 2 3\n");
    const SceneParts parts = loadScene(
        folder.write("scene.pbrt", pbrtScene("Shape \"plymesh\" \"string filename\" \"mesh.ply\"\n")), {});
    ASSERT_EQ(parts.shapes.size(), 1u);
    EXPECT_TRUE(static_cast<const TriangleMesh&>(*parts.shapes[0]).normals.empty());
    EXPECT_FLOAT_EQ(parts.shapes[0]->area(), 6);
}

TEST(Pbrt, CamerasHaveTheirRightOnTheRight) {
    // A red lamp toward up x direction of view, a green one above.
    const std::string lamps = R"(AttributeBegin AreaLightSource "diffuse" "rgb L" [1 0 0] Translate -1 0 0
Shape "sphere" "float radius" 0.3 AttributeEnd
AreaLightSource "diffuse" "rgb L" [0 1 0] Translate 0 1 0 Shape "sphere" "float radius" 0.3)";
    const auto picture = [&](const std::string& camera) {
        const TemporaryFolder folder;
        const RenderableScene scene(
            folder.write("scene.pbrt",
                         "LookAt 0 0 3 0 0 0 0 1 0\n" + camera +
                             "\nFilm \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" 20\n"
                             "PixelFilter \"box\"\nWorldBegin\n" +
                             lamps),
            {});
        return scene.render("path", 4, 1);
    };
    // Where, in pixels, a color is seen in the mean.
    const auto center = [](const std::vector<float>& image, size_t channel) {
        double sum = 0, x = 0, y = 0;
        for (size_t i = 0; i < 800; ++i) {
            const double v = double(image[3 * i + channel]);
            sum += v, x += v * (double(i % 40) + 0.5), y += v * (double(i / 40) + 0.5);
        }
        return Vec2f(static_cast<float>(x / sum), static_cast<float>(y / sum));
    };
    // Right is up x view: (0, 1, 0) x (0, 0, -1) = (-1, 0, 0). The shorter side has the field of view.
    const std::vector<float> perspective = picture("Camera \"perspective\" \"float fov\" 60");
    const double pixels = 10 / std::tan(30 * kPiF / 180) / 3;
    EXPECT_NEAR(center(perspective, 0).x, 20 + pixels, 0.3);
    EXPECT_NEAR(center(perspective, 0).y, 10, 0.1);
    EXPECT_NEAR(center(perspective, 1).x, 20, 0.1);
    EXPECT_NEAR(center(perspective, 1).y, 10 - pixels, 0.3);
    const std::vector<float> window =
        picture("Camera \"perspective\" \"float fov\" 90 \"float screenwindow\" [-1 1 -0.5 0.5]");
    EXPECT_NEAR(center(window, 1).y, 10 - 20 / 3.0, 0.3);
    const std::vector<float> orthographic =
        picture("Camera \"orthographic\" \"float screenwindow\" [-4 4 -2 2]");
    EXPECT_NEAR(center(orthographic, 0).x, 25, 0.2);
    EXPECT_NEAR(center(orthographic, 1).y, 5, 0.2);
    // x = phi / 2 pi, from +x to +z of the camera: what is ahead is at a quarter.
    const std::vector<float> panorama =
        picture("Camera \"spherical\" \"string mapping\" \"equirectangular\"");
    EXPECT_NEAR(center(panorama, 1).x, 10, 0.2);
    EXPECT_NEAR(center(panorama, 0).x, 10 - std::atan(1 / 3.0) / (2 * kPiF) * 40, 0.2);
    EXPECT_NEAR(center(panorama, 1).y, 10 - std::atan(1 / 3.0) / kPiF * 20, 0.2);
}

TEST(Pbrt, FilmFilterAndIntegrator) {
    const SceneParts parts = loadedPbrt(R"(Camera "perspective"
Film "rgb" "integer xresolution" 100 "integer yresolution" 50 "float cropwindow" [0.2 0.7 0 0.5]
PixelFilter "mitchell" "float B" 0.2 "float C" 0.4
Sampler "halton" "integer pixelsamples" 4
Integrator "bdpt" "integer maxdepth" 7
WorldBegin LightSource "infinite")");
    const FilmWindow& w = parts.camera->window();
    EXPECT_EQ(w.fullWidth, 100);
    EXPECT_EQ(w.x, 20);
    EXPECT_EQ(w.width, 50);
    EXPECT_EQ(w.height, 25);
    EXPECT_EQ(parts.filterKind, ReconstructionFilter::Kind::Mitchell);
    EXPECT_FLOAT_EQ(parts.filter.c, 0.4f);
    EXPECT_EQ(parts.limits.maxDepth, 8);
    EXPECT_EQ(parts.integrator.type, "bdpt");
    EXPECT_TRUE(parts.warnings.empty()) << parts.warnings[0];
}

TEST(Pbrt, RefusalsNameTheirPlace) {
    const std::pair<const char*, const char*> cases[] = {
        {"Shpae \"sphere\"", "scene.pbrt:6: found the directive \"Shpae\" (did you mean Shape?)"},
        {"Shape \"shpere\"",
         "scene.pbrt:6: Shape \"shpere\": the shape \"shpere\" is not supported (did you mean \"sphere\"?)"},
        {"Shape \"sphere\" \"float raduis\" 2",
         "\"float raduis\", which is unknown here; did you mean \"radius\"?"},
        {"Shape \"sphere\"\n  \"float radius\" [1 2]",
         "scene.pbrt:7: \"float radius\": found 2 values, expected 1 number"},
        {"Shape \"sphere\" \"flaot radius\" 1",
         "scene.pbrt:6: found the type \"flaot\" of a parameter (did you mean \"float\"?)"},
        {"Shape \"sphere\" \"float radius\" \"a\"", "expected a value of \"float radius\""},
        {"Shape \"sphere\" \"float radius\" -1", "expected more than zero"},
        {"Shape sphere", "found sphere, expected a quoted text after Shape"},
        {"Shape \"sphere", "found a string without an end"},
        {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
         "found the index 3, expected 0 to 2"},
        {"Shape \"nurbs\"", "the shape \"nurbs\" is not supported"},
        {"Material \"hair\" Shape \"sphere\"", "the material \"hair\" is not supported"},
        {"Material \"difuse\" Shape \"sphere\"", "did you mean \"diffuse\"?"},
        {"NamedMaterial \"x\"", "found no material of the name \"x\""},
        {"Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"",
         "found no texture of the name \"t\""},
        {"Texture \"t\" \"spectrum\" \"ptex\"", "textures of the class \"ptex\" are not supported"},
        {"MakeNamedMedium \"m\" \"string type\" \"cloud\"", "the medium \"cloud\" is not supported"},
        {"MediumInterface \"m\" \"\" Shape \"sphere\"", "found no medium of the name \"m\""},
        {"AttributeEnd", "found AttributeEnd without its beginning"},
        {"AttributeBegin", "found the end of the file, expected AttributeEnd"},
        {"AttributeBegin ObjectEnd", "found ObjectEnd, expected AttributeEnd first"},
        {"ObjectInstance \"o\"", "found no object \"o\""},
        {"Translate 1 2", "expected 3 numbers after Translate"},
        {"Translate 1 2 1e999", "expected a finite number"},
        {"Include \"nothing.pbrt\"", "nothing.pbrt"},
        {"CoordSysTransform \"x\"", "has not been named before"},
        {"MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [\"a\" \"a\"] NamedMaterial "
         "\"a\" Shape \"sphere\"",
         "is a mix of itself"}};
    for (const auto& [text, expected] : cases)
        EXPECT_THAT(errorOf([&] { loadedPbrt(pbrtScene(text)); }), HasSubstr(expected)) << text;
}

TEST(Pbrt, LenientlyWhatIsUnknownHasAStandIn) {
    LoadOptions lenient;
    lenient.lenient = true;
    for (const char* text :
         {"Shape \"nurbs\" \"float width\" 1", "Material \"hair\" \"float eumelanin\" 1 Shape \"sphere\"",
          "Texture \"t\" \"spectrum\" \"ptex\" Material \"diffuse\" \"texture reflectance\" \"t\" Shape "
          "\"disk\"",
          "Shape \"sphere\" \"float what\" 1", "MakeNamedMedium \"m\" \"string type\" \"nanovdb\"",
          "AreaLightSource \"odd\" Shape \"sphere\""}) {
        const SceneParts parts =
            loadedPbrt(pbrtScene("LightSource \"infinite\"\n" + std::string(text)), lenient);
        ASSERT_EQ(parts.warnings.size(), 1u) << text;
        EXPECT_THAT(parts.warnings[0], HasSubstr("scene.pbrt:7"));
    }
}

}  // namespace
}  // namespace metrolux::core::test
