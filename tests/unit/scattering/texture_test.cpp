#include "base/error.h"
#include "bsdf_checks.h"
#include "geometry/shape.h"
#include "scattering/textures/bitmap_texture.h"
#include "scattering/textures/checkerboard.h"
#include "scattering/textures/constant.h"
#include "scattering/textures/mesh_attribute.h"

#include <gtest/gtest.h>

#include <numeric>

namespace metrolux::core {
namespace {

using test::flatInteraction;
using Bitmap = BitmapTextureParameters;

/// width x height, one channel, pixel i has the value i.
Bitmap numbered(int width, int height) {
    std::vector<float> values(static_cast<size_t>(width * height));
    std::iota(values.begin(), values.end(), 0.0f);
    Bitmap p;
    p.width = width;
    p.height = height;
    p.channels = 1;
    p.pixels = std::make_shared<std::vector<float>>(std::move(values));
    return p;
}
float at(const TexturePtr& texture, float u, float v) { return texture->scalar(flatInteraction({u, v})); }

TEST(BitmapTexture, BilinearBetweenTexelCenters) {
    const TexturePtr t = makeBitmapTexture(numbered(4, 2));
    EXPECT_FLOAT_EQ(at(t, 0.125f, 0.25f), 0) << "center of the first pixel of the first row";
    EXPECT_FLOAT_EQ(at(t, 0.875f, 0.75f), 7) << "v grows from row to row";
    EXPECT_FLOAT_EQ(at(t, 0.25f, 0.5f), 0.25f * (0 + 1 + 4 + 5));
    EXPECT_FLOAT_EQ(t->mean().x, 3.5f);
    EXPECT_EQ(t->resolution(), Vec2i(4, 2));
}

/// With 256 values and with one more: the first are kept as bytes, the second as numbers.
TEST(BitmapTexture, KeepsEveryValueExactly) {
    for (const int values : {1, 255, 256, 257, 1000}) {
        Bitmap p;
        p.width = 25;
        p.height = 16;
        p.filter = Bitmap::Filter::Nearest;
        std::vector<float> pixels;
        for (int i = 0; i < p.width * p.height * 3; ++i)
            pixels.push_back(std::sqrt(static_cast<float>(i * 7 % values)) - 3.0f);
        pixels[0] = -0.0f;
        pixels[1] = 0.0f;
        p.pixels = std::make_shared<std::vector<float>>(pixels);
        const TexturePtr t = makeBitmapTexture(p);
        for (int y = 0; y < p.height; ++y)
            for (int x = 0; x < p.width; ++x) {
                const SurfaceInteraction si = flatInteraction(
                    {(static_cast<float>(x) + 0.5f) / 25, (static_cast<float>(y) + 0.5f) / 16});
                const size_t i = 3 * static_cast<size_t>(y * p.width + x);
                ASSERT_EQ(t->rgb(si), Rgb(pixels[i], pixels[i + 1], pixels[i + 2])) << values;
            }
    }
}

TEST(BitmapTexture, WrapModes) {
    Bitmap p = numbered(4, 1);
    p.filter = Bitmap::Filter::Nearest;
    const auto row = [&](Bitmap::Wrap wrap) {
        p.wrapU = p.wrapV = wrap;
        const TexturePtr t = makeBitmapTexture(p);
        std::vector<float> values;
        for (int i = -5; i <= 9; ++i) values.push_back(at(t, (static_cast<float>(i) + 0.5f) / 4, 0.5f));
        return values;
    };
    EXPECT_EQ(row(Bitmap::Wrap::Repeat), (std::vector<float>{3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1}));
    EXPECT_EQ(row(Bitmap::Wrap::Mirror), (std::vector<float>{3, 3, 2, 1, 0, 0, 1, 2, 3, 3, 2, 1, 0, 0, 1}));
    EXPECT_EQ(row(Bitmap::Wrap::Clamp), (std::vector<float>{0, 0, 0, 0, 0, 0, 1, 2, 3, 3, 3, 3, 3, 3, 3}));
    EXPECT_EQ(row(Bitmap::Wrap::Zero), (std::vector<float>{0, 0, 0, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(row(Bitmap::Wrap::One), (std::vector<float>{1, 1, 1, 1, 1, 0, 1, 2, 3, 1, 1, 1, 1, 1, 1}));
}

TEST(BitmapTexture, GradientIsTheDerivativeOfThePatch) {
    Bitmap p = numbered(5, 3);
    p.toUv = {{{0.8f, 0.3f, 0.1f}, {-0.2f, 0.7f, 0.2f}}};
    const TexturePtr t = makeBitmapTexture(p);
    const Vec2f uv(0.43f, 0.37f), g = t->gradient(flatInteraction(uv));
    constexpr float kStep = 1e-3f;
    EXPECT_NEAR(g.x, (at(t, uv.x + kStep, uv.y) - at(t, uv.x - kStep, uv.y)) / (2 * kStep), 2e-2);
    EXPECT_NEAR(g.y, (at(t, uv.x, uv.y + kStep) - at(t, uv.x, uv.y - kStep)) / (2 * kStep), 2e-2);
}

TEST(BitmapTexture, ColorAndErrors) {
    Bitmap p;
    p.width = p.height = 1;
    p.pixels = std::make_shared<std::vector<float>>(std::vector<float>{1, 0.5f, 0.25f});
    const TexturePtr t = makeBitmapTexture(p);
    EXPECT_EQ(t->rgb(flatInteraction()), Rgb(1, 0.5f, 0.25f));
    EXPECT_FLOAT_EQ(t->scalar(flatInteraction()), luminance(Rgb(1, 0.5f, 0.25f)));
    p.width = 2;
    EXPECT_THROW(makeBitmapTexture(p), Error);
}

TEST(Checkerboard, Squares) {
    CheckerboardParameters p{makeConstantTexture(Rgb(1, 0, 0)), makeConstantTexture(Rgb(0, 1, 0)), {}};
    const TexturePtr t = makeCheckerboard(p);
    EXPECT_EQ(t->rgb(flatInteraction({0.2f, 0.2f})), Rgb(1, 0, 0));
    EXPECT_EQ(t->rgb(flatInteraction({0.7f, 0.2f})), Rgb(0, 1, 0));
    EXPECT_EQ(t->rgb(flatInteraction({0.7f, -0.2f})), Rgb(1, 0, 0));
    EXPECT_EQ(t->mean(), Rgb(0.5f, 0.5f, 0));
    EXPECT_FLOAT_EQ(at(t, 0.2f, 0.2f), luminance(Rgb(0, 1, 0))) << "scalars: exchanged, as in Mitsuba";
    p.toUv.m[0][0] = p.toUv.m[1][1] = 10;
    EXPECT_EQ(makeCheckerboard(p)->rgb(flatInteraction({0.07f, 0.02f})), Rgb(0, 1, 0));
}

/// Geometry is another module: a shape that answers with its barycentric coordinates.
class AttributeShape final : public Shape {
  public:
    float area() const override { return 1; }
    ShapeSample sampleArea(const Vec2f&) const override { return {}; }
    void bounds(Vec3f& lower, Vec3f& upper) const override { lower = upper = Vec3f(0, 0, 0); }
    Partials partialsAt(const SurfaceInteraction&) const override { return {}; }
    bool attribute(const std::string& name, const SurfaceInteraction& si, Rgb& value) const override {
        value = {si.barycentric.x, si.barycentric.y, 0};
        return name == "vertex_color";
    }
};

TEST(MeshAttribute, ReadsTheShape) {
    const AttributeShape shape;
    SurfaceInteraction si = flatInteraction();
    si.shape = &shape;
    const TexturePtr t = makeMeshAttribute({"vertex_color", 2});
    EXPECT_EQ(t->rgb(si), Rgb(2 * si.barycentric.x, 2 * si.barycentric.y, 0));
    EXPECT_EQ(makeMeshAttribute({"vertex_none", 1})->rgb(si), Rgb(0.0f));
}

}  // namespace
}  // namespace metrolux::core
