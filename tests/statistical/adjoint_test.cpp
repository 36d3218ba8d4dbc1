/// Light subpaths against eye subpaths: whatever makes scattering asymmetric (interpolated, bumped and mapped
/// normals, refraction), every kind of light, crop windows, and the reconstruction filters up to the borders
/// of the image. Path tracing is the reference; it uses no adjoint. Error rates: rendering.h.

#include "rendering.h"
#include "scattering/bump_map.h"
#include "scattering/normal_map.h"
#include "scattering/textures/bitmap_texture.h"

namespace metrolux::core {
namespace {

using namespace test;

/// A sphere of 8 x 5 quads whose vertex normals are those of the true sphere: up to 20 degrees from the
/// faces'.
ShapePtr coarseSphere(const Vec3f& center, float radius) {
    constexpr int kColumns = 8, kRows = 5;
    auto mesh = std::make_shared<TriangleMesh>();
    for (int row = 0; row <= kRows; ++row)
        for (int column = 0; column <= kColumns; ++column) {
            const float theta = kPi * static_cast<float>(row) / kRows,
                        phi = 2 * kPi * static_cast<float>(column) / kColumns;
            const Vec3f n(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
            mesh->positions.push_back(center + n * radius);
            mesh->normals.push_back(n);
            mesh->uvs.emplace_back(static_cast<float>(column) / kColumns, static_cast<float>(row) / kRows);
        }
    for (uint32_t row = 0; row < kRows; ++row)
        for (uint32_t column = 0; column < kColumns; ++column) {
            const uint32_t a = row * (kColumns + 1) + column, b = a + kColumns + 1;
            for (const uint32_t i : {a, b, b + 1, a, b + 1, a + 1}) mesh->indices.push_back(i);
        }
    mesh->finalize();
    return mesh;
}

TexturePtr bitmap(int size, int channels, const std::function<float(int, int, int)>& value) {
    auto pixels = std::make_shared<std::vector<float>>();
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            for (int c = 0; c < channels; ++c) pixels->push_back(value(x, y, c));
    BitmapTextureParameters p;
    p.width = p.height = size;
    p.channels = channels;
    p.pixels = pixels;
    return makeBitmapTexture(p);
}

BsdfPtr bumped(BsdfPtr nested) {
    BumpMapParameters p;
    p.height = bitmap(8, 1, [](int x, int y, int) {
        return 0.5f + 0.5f * std::sin(1.7f * float(x)) * std::cos(2.3f * float(y));
    });
    p.scale = 0.3f;
    p.nested = std::move(nested);
    return makeBumpMap(p);
}

BsdfPtr normalMapped(BsdfPtr nested) {
    NormalMapParameters p;
    p.normals = bitmap(4, 3, [](int x, int y, int c) {
        const Vec3f n =
            normalize(Vec3f(0.5f * std::sin(2.0f * float(x)), 0.5f * std::cos(3.0f * float(y)), 1));
        return 0.5f + 0.5f * n[c];
    });
    p.nested = std::move(nested);
    return makeNormalMap(p);
}

/// What it takes to decide: passes for path, for light tracing, for the bidirectional ones.
void compare(const Scene& scene, const std::vector<std::pair<std::string, int>>& others, int pathPasses,
             double detectable, const std::string& what) {
    RenderSetup reference;
    reference.integrator = "path";
    reference.passes = pathPasses;
    const BlockStatistics expected = renderSeeds(scene, reference);
    EXPECT_GT(expected.total(), 0) << what;
    for (const auto& [name, passes] : others) {
        RenderSetup setup;
        setup.integrator = name;
        setup.passes = passes;
        setup.radius = 0.02;
        setup.seed = 2;
        expectSame(expected, renderSeeds(scene, setup), detectable, what + ": path and " + name);
    }
}

FilmWindow window(int width, int height) {
    FilmWindow w;
    w.fullWidth = w.width = width;
    w.fullHeight = w.height = height;
    return w;
}

/// A floor and a coarse sphere under a large light. Nothing specular, so that light tracing sees all.
SceneBuilder shadedScene(BsdfPtr sphere, BsdfPtr floor) {
    SceneBuilder b;
    b.add(rectangle({0, 0, 0}, {0, 1, 0}, 1.6f, 1.6f), std::move(floor));
    b.add(coarseSphere({0, 0.7f, 0}, 0.7f), std::move(sphere));
    b.emit(b.add(rectangle({1.2f, 2.2f, 0.6f}, {-0.5f, -1, -0.3f}, 0.9f, 0.9f), diffuse(0.2f)), Rgb(3));
    b.camera({0, 1.4f, 3.2f}, {0, 0.5f, 0}, 45, window(18, 15));
    b.limits().maxDepth = 4;
    b.limits().rouletteDepth = 100;
    return b;
}

BsdfPtr roughMetal() {
    RoughConductorParameters p;
    p.alphaU = p.alphaV = constant(Rgb(0.4f));
    return makeRoughConductor(p);
}

TEST(Adjoint, InterpolatedNormals) {
    for (const bool metal : {false, true})
        compare(*shadedScene(metal ? roughMetal() : diffuse(0.9f), diffuse(0.6f)).build(),
                {{"light", 256}, {"bdpt", 16}, {"vcm", 16}}, 64, 0.15, metal ? "rough metal" : "diffuse");
}

TEST(Adjoint, BumpedAndMappedNormals) {
    compare(*shadedScene(bumped(diffuse(0.9f)), normalMapped(diffuse(0.7f))).build(),
            {{"light", 160}, {"bdpt", 16}, {"vcm", 16}}, 48, 0.15, "bump and normal map");
    compare(*shadedScene(normalMapped(roughMetal()), bumped(diffuse(0.7f))).build(),
            {{"light", 160}, {"bdpt", 16}, {"vcm", 16}}, 48, 0.15, "normal map on metal");
}

TEST(Adjoint, RefractionSeenAndLit) {
    // A glass plate (an odd number of interfaces over the floor: it is water), and a glass ball in view.
    SceneBuilder b = shadedScene(diffuse(0.8f), diffuse(0.6f));
    DielectricParameters glass;
    glass.eta = 1.5f;
    b.add(makeSphere(Transform(), {-0.9f, 0.45f, 0.9f}, 0.4f, false), makeDielectric(glass));
    b.add(rectangle({1, 0.15f, 0.3f}, {0, 1, 0}, 0.6f, 1.2f), makeDielectric(glass));
    b.light(makeConstantLight({Rgb(0.3f)}));
    b.limits().maxDepth = 6;
    compare(*b.build(), {{"bdpt", 32}, {"vcm", 32}}, 64, 0.25, "glass");
}

enum class Kind { Area, SphereArea, Point, Spot, Directional, Constant };

const char* nameOf(Kind kind) {
    constexpr const char* kNames[] = {"Area", "SphereArea", "Point", "Spot", "Directional", "Constant"};
    return kNames[static_cast<int>(kind)];
}

void addLight(SceneBuilder& b, Kind kind) {
    switch (kind) {
        case Kind::Area:
            b.emit(b.add(rectangle({0.6f, 2, 0}, {-0.2f, -1, 0}, 0.5f, 0.4f), diffuse(0.3f)), Rgb(5));
            return;
        case Kind::SphereArea:
            b.emit(b.add(makeSphere(Transform(), {0.6f, 1.8f, 0}, 0.3f, false), diffuse(0.3f)), Rgb(5));
            return;
        case Kind::Point: {
            PointLightParameters p;
            p.position = {0.6f, 1.8f, 0.2f};
            b.light(makePointLight(p));
            return;
        }
        case Kind::Spot: {
            SpotLightParameters p;
            p.toWorld = Transform::lookAt({0.6f, 2.2f, 0.2f}, {0, 0, 0}, {0, 0, 1});
            p.cutoffAngle = 50;
            p.beamWidth = 20;
            b.light(makeSpotLight(p));
            return;
        }
        case Kind::Directional: {
            DirectionalLightParameters p;
            p.direction = normalize(Vec3f(-0.3f, -1, -0.2f));
            b.light(makeDirectionalLight(p));
            return;
        }
        case Kind::Constant:
            b.light(makeConstantLight({}));
            return;
    }
}

class EachLight : public ::testing::TestWithParam<Kind> {};

TEST_P(EachLight, GivesOneImageInACropWindow) {
    SceneBuilder b;
    b.add(rectangle({0, 0, 0}, {0, 1, 0}, 1.2f, 1.2f), diffuse(0.7f));
    b.add(makeSphere(Transform(), {-0.2f, 0.5f, 0}, 0.5f, false), diffuse(0.8f));
    addLight(b, GetParam());
    FilmWindow w = window(30, 24);
    w.x = 6, w.y = 5, w.width = 18, w.height = 15;
    b.camera({0, 1.2f, 2.6f}, {0, 0.4f, 0}, 50, w);
    b.limits().maxDepth = 4;
    b.limits().rouletteDepth = 100;
    compare(*b.build(), {{"light", 128}, {"bdpt", 12}, {"vcm", 12}}, 24, 0.25, nameOf(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(All, EachLight,
                         ::testing::Values(Kind::Area, Kind::SphereArea, Kind::Point, Kind::Spot,
                                           Kind::Directional, Kind::Constant),
                         [](const auto& i) { return std::string(nameOf(i.param)); });

TEST(Crop, RepeatsThePixelsOfTheWholeImage) {
    // Path tracing: bit by bit.
    SceneBuilder whole = shadedScene(diffuse(0.8f), diffuse(0.6f)),
                 part = shadedScene(diffuse(0.8f), diffuse(0.6f));
    FilmWindow w = window(18, 15);
    w.x = 4, w.y = 3, w.width = 7, w.height = 8;
    part.camera({0, 1.4f, 3.2f}, {0, 0.5f, 0}, 45, w);
    RenderSetup setup;
    setup.integrator = "path";
    setup.passes = 4;
    setup.filter = ReconstructionFilter::Kind::Gaussian;
    const std::vector<float> all = renderImage(*whole.build(), setup, 5),
                             crop = renderImage(*part.build(), setup, 5);
    for (int y = 0; y < w.height; ++y)
        for (int x = 0; x < w.width; ++x)
            for (int c = 0; c < 3; ++c)
                ASSERT_EQ(crop[(y * w.width + x) * 3 + c], all[((y + w.y) * 18 + x + w.x) * 3 + c])
                    << x << " " << y;
}

class EachFilter : public ::testing::TestWithParam<ReconstructionFilter::Kind> {};

TEST_P(EachFilter, KeepsAUniformImageUniformUpToItsBorders) {
    // A wall before a white sky has the radiance of its albedo in each pixel; each row and each column is
    // tested, so that the border has a test of its own. Splats near it must not lose what falls outside.
    SceneBuilder b;
    b.add(rectangle({0, 0, 0}, {0, 0, 1}, 0.92f, 0.75f), diffuse(0.5f));
    b.light(makeConstantLight({}));
    FilmWindow w = window(10, 8);
    b.camera({0, 0, 1.5f}, {0, 0, 0}, 60, w);
    b.limits().maxDepth = 2;
    const std::shared_ptr<Scene> full = b.build();

    for (const char* integrator : {"path", "light", "bdpt"})
        for (const bool rows : {true, false}) {
            RenderSetup setup;
            setup.integrator = integrator;
            setup.filter = GetParam();
            setup.passes = std::string(integrator) == "light" ? 200 : 32;
            setup.columns = rows ? 1 : w.width;
            setup.rows = rows ? w.height : 1;
            expectRadiance(renderSeeds(*full, setup), 0.5, 0.3,
                           fmt::format("{} {}", integrator, rows ? "rows" : "columns"));
        }
}

INSTANTIATE_TEST_SUITE_P(All, EachFilter,
                         ::testing::Values(ReconstructionFilter::Kind::Box, ReconstructionFilter::Kind::Tent,
                                           ReconstructionFilter::Kind::Gaussian,
                                           ReconstructionFilter::Kind::Mitchell,
                                           ReconstructionFilter::Kind::CatmullRom,
                                           ReconstructionFilter::Kind::Lanczos));

}  // namespace
}  // namespace metrolux::core
