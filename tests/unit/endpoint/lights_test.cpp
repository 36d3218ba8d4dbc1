/// Every light: connect(), sampleRay() and the densities tell one story, and the energy is right.

#include "base/error.h"
#include "base/warp.h"
#include "chi_square.h"
#include "geometry/intersector.h"
#include "light_cases.h"

namespace metrolux::core {
namespace {

using test::expectClose;
using test::LightCase;

std::vector<Vec3f> receivers() {
    return {{1.4f, 0.3f, 0.8f}, {-0.9f, -1.2f, 1.1f}, {0.5f, 1.9f, -1.0f}, {0.21f, 0.5f, -1.5f}};
}

class EveryLight : public ::testing::TestWithParam<int> {
  protected:
    LightCase c = test::lightCase(GetParam());
    const Light& light = *c.light;
    CounterRng rng{hashKey(2024, GetParam())};
};

TEST_P(EveryLight, connectionsAgreeWithDensitiesAndRadiance) {
    SCOPED_TRACE(c.name);
    std::unique_ptr<Intersector> intersector;
    if (c.shape)
        intersector = std::make_unique<Intersector>(std::vector<ShapePtr>{c.shape}, std::vector<Instance>{});
    int found = 0;
    for (const Vec3f& x : receivers())
        for (int i = 0; i < 500; ++i) {
            const std::optional<EndpointConnection> e = light.connect(x, rng.next2D());
            if (!e) continue;
            ++found;
            EXPECT_NEAR(e->wi.length(), 1, 1e-5);
            EXPECT_NEAR((x + e->wi * e->distance - e->point).length(), 0, 1e-4f * e->distance);
            EXPECT_TRUE(isFinite(e->value) && e->pdf > 0 && e->pdfPosition > 0 && e->pdfDirection > 0 &&
                        e->cosine > 0);
            EXPECT_EQ(light.isInfinite() && e->distance < test::kBounds.radius, false);
            if (c.shape) {
                // The point is the nearest one, or hidden behind another part of the shape.
                SurfaceInteraction si;
                if (!intersector->intersect({x, e->wi, kInfinity}, si)) continue;
                if ((si.p - e->point).length() > 1e-3f) continue;
                const EndpointDensities d = light.densities(x, si);
                expectClose(d.connect, e->pdf, 5e-3, "density of connecting");
                expectClose(d.pdfPosition, e->pdfPosition, 2e-3, "density of the position");
                expectClose(d.pdfDirection, e->pdfDirection, 5e-3, "density of the direction");
                expectClose(d.cosine, e->cosine, 5e-3, "cosine");
                expectClose(e->value * e->pdf, light.radiance(si, -e->wi), 5e-3, "radiance");
            } else if (light.isEnvironment()) {
                const EndpointDensities d = light.environmentDensities(x, e->wi);
                EXPECT_EQ(d.connect, e->pdf);
                EXPECT_EQ(d.pdfPosition, e->pdfPosition);
                EXPECT_EQ(d.pdfDirection, e->pdfDirection);
                expectClose(e->value * e->pdf, light.environmentRadiance(e->wi), 1e-4, "radiance");
            } else {
                EXPECT_TRUE(light.isDelta());
                EXPECT_EQ(e->pdf, 1);
            }
        }
    const bool behind =
        c.name.find("spot") != std::string::npos || c.name == "projector" || c.name == "collimated";
    EXPECT_TRUE(found > 100 || behind) << found;
}

TEST_P(EveryLight, raysAgreeWithDensitiesAndConnections) {
    SCOPED_TRACE(c.name);
    int found = 0;
    for (int i = 0; i < 3000; ++i) {
        const Vec2f uPosition = rng.next2D(), uDirection = rng.next2D();
        const std::optional<EndpointRay> ray = light.sampleRay(uPosition, uDirection);
        if (!ray) continue;
        ++found;
        EXPECT_NEAR(ray->direction.length(), 1, 1e-5);
        EXPECT_TRUE(isFinite(ray->weight) && ray->pdfPosition > 0 && ray->pdfDirection > 0 &&
                    ray->cosine > 0);
        const Vec3f x = ray->origin + ray->direction * (light.isInfinite() ? test::kBounds.radius : 1.3f);
        const Rgb emitted = ray->weight * (ray->pdfPosition * ray->pdfDirection / ray->cosine);
        if (c.shape) {
            EXPECT_EQ(ray->ng, ray->surface.ng);
            EXPECT_EQ(ray->origin, ray->surface.p);
            const EndpointDensities d = light.densities(x, ray->surface);
            expectClose(d.pdfPosition, ray->pdfPosition, 1e-5, "density of the position");
            expectClose(d.pdfDirection, ray->pdfDirection, 1e-3, "density of the direction", 1e-3);
            expectClose(d.cosine, ray->cosine, 1e-3, "cosine", 1e-3);
            expectClose(emitted, light.radiance(ray->surface, ray->direction), 1e-4, "radiance");
        } else if (light.isEnvironment()) {
            EXPECT_EQ(ray->ng, Vec3f(0.0f));
            const EndpointDensities d = light.environmentDensities(x, -ray->direction);
            EXPECT_EQ(d.pdfPosition, ray->pdfPosition);
            EXPECT_EQ(d.pdfDirection, ray->pdfDirection);
            expectClose(emitted, light.environmentRadiance(-ray->direction), 1e-4, "radiance");
        } else if (light.isConnectable()) {
            const std::optional<EndpointConnection> e = light.connect(x, uPosition);
            if (!e) continue;  // at the edge of a cone, by rounding
            expectClose(e->pdfPosition, ray->pdfPosition, 1e-5, "density of the position");
            expectClose(e->pdfDirection, ray->pdfDirection, 1e-3, "density of the direction");
            EXPECT_NEAR((e->wi + ray->direction).length(), 0, 1e-4);
            const float falloff = light.isInfinite() ? 1 : sqr(e->distance);
            expectClose(e->value * falloff, emitted, 2e-2, "intensity");
        }
    }
    EXPECT_GT(found, 300);
}

TEST_P(EveryLight, powerIsTheMeanWeight) {
    SCOPED_TRACE(c.name);
    test::Mean mean;
    for (int i = 0; i < 60000; ++i) {
        const Vec2f uPosition = rng.next2D(), uDirection = rng.next2D();
        const std::optional<EndpointRay> ray = light.sampleRay(uPosition, uDirection);
        mean.add(ray ? luminance(ray->weight) : 0);
    }
    // Textures give the mean over uv, which is not that over a sphere's area or a spot's cone.
    if (c.name == "textured sphere" || c.name == "textured spot") {
        EXPECT_GT(light.power(), 0.3 * mean.value());
        EXPECT_LT(light.power(), 3 * mean.value());
    } else {
        // Textures with clamped borders: their texel mean is not exactly the interpolant's.
        const double expected = light.power();
        EXPECT_NEAR(mean.value(), expected,
                    5 * mean.error() +
                        (c.name.find("textured") + 1 || c.name == "projector" ? 0.15 : 2e-3) * expected);
    }
}

TEST_P(EveryLight, boundsHoldWhatLeaves) {
    SCOPED_TRACE(c.name);
    const std::optional<LightBounds> b = light.bounds();
    ASSERT_EQ(b.has_value(), light.isConnectable() && !light.isInfinite());
    if (!b) return;
    EXPECT_NEAR(b->normals.axis.length(), 1, 1e-5);
    EXPECT_GE(b->cosEmission, 0);
    constexpr float kMargin = 1e-5f;
    const float limit = cosOfSum(b->normals.cosine, b->cosEmission);
    float mostAxial = -1, leastAxial = 1;
    Vec3f lower(kInfinity), upper(-kInfinity);
    for (int i = 0; i < 20000; ++i) {
        const Vec2f uPosition = rng.next2D(), uDirection = rng.next2D();
        const std::optional<EndpointRay> ray = light.sampleRay(uPosition, uDirection);
        if (!ray) continue;
        for (int axis = 0; axis < 3; ++axis) {
            ASSERT_GE(ray->origin[axis], b->lower[axis] - kMargin);
            ASSERT_LE(ray->origin[axis], b->upper[axis] + kMargin);
            lower[axis] = std::min(lower[axis], ray->origin[axis]);
            upper[axis] = std::max(upper[axis], ray->origin[axis]);
        }
        const float axial = dot(ray->direction, b->normals.axis);
        ASSERT_GE(axial, limit - kMargin);
        leastAxial = std::min(leastAxial, axial);
        mostAxial = std::max(mostAxial, axial);
        if (!c.shape) continue;
        ASSERT_GE(dot(ray->ng, b->normals.axis), b->normals.cosine - kMargin);
    }
    // And they are not much larger: the box is filled, and the directions are.
    EXPECT_LT(((b->upper - b->lower) - (upper - lower)).length(),
              0.2f * (b->upper - b->lower).length() + kMargin);
    EXPECT_GT(mostAxial, 0.99f);
    EXPECT_LT(leastAxial, limit + 0.1f);
}

TEST_P(EveryLight, intensityIsThatWhereItShines) {
    SCOPED_TRACE(c.name);
    const std::optional<LightBounds> b = light.bounds();
    if (!b || c.name == "sphere from inside") return;  // that is dark from afar
    // Over all directions it is less or the same, and it is reached in some.
    constexpr float kFar = 1000;
    constexpr int kDirections = 400, kPoints = 64;
    double mean = 0, most = 0;
    for (int i = 0; i < kDirections; ++i) {
        const Vec3f x = (b->lower + b->upper) * 0.5f + warp::squareToSphere(rng.next2D()) * kFar;
        double value = 0;
        for (int j = 0; j < kPoints; ++j)
            if (const auto connection = light.connect(x, rng.next2D()))
                value += double(luminance(connection->value)) * sqr(double(kFar)) / kPoints;
        mean += value / kDirections;
        most = std::max(most, value);
    }
    EXPECT_LT(mean, 1.2 * b->intensity);
    EXPECT_GT(most, 0.8 * b->intensity);
}

/// Irradiance on a small sphere by connections must be that by the light's radiance over uniform directions.
TEST_P(EveryLight, connectionsGiveTheIrradiance) {
    SCOPED_TRACE(c.name);
    if (light.isDelta()) return;  // no radiance to compare with
    std::unique_ptr<Intersector> intersector;
    if (c.shape)
        intersector = std::make_unique<Intersector>(std::vector<ShapePtr>{c.shape}, std::vector<Instance>{});
    double total = 0;
    for (const Vec3f& x : receivers()) {
        test::Mean byConnection, bySphere;
        for (int i = 0; i < 50000; ++i) {
            const std::optional<EndpointConnection> e = light.connect(x, rng.next2D());
            const bool hidden = e && c.shape && intersector->occluded({x, e->wi, e->distance * (1 - 1e-3f)});
            byConnection.add(e && !hidden ? luminance(e->value) : 0);
            const Vec3f w = warp::squareToSphere(rng.next2D());
            SurfaceInteraction si;
            Rgb seen(0.0f);
            if (!c.shape)
                seen = light.environmentRadiance(w);
            else if (intersector->intersect({x, w, kInfinity}, si))
                seen = light.radiance(si, -w);
            bySphere.add(4 * kPi * luminance(seen));
        }
        // The difference of two independent means: five standard errors.
        const double error = std::hypot(byConnection.error(), bySphere.error());
        EXPECT_NEAR(byConnection.value(), bySphere.value(), 5 * error + 1e-3 * bySphere.value());
        total += bySphere.value();
    }
    EXPECT_GT(total, 0);
}

INSTANTIATE_TEST_SUITE_P(Lights, EveryLight, ::testing::Range(0, static_cast<int>(test::allLights().size())),
                         [](const ::testing::TestParamInfo<int>& p) {
                             std::string name = test::allLights()[static_cast<size_t>(p.param)].name;
                             std::replace(name.begin(), name.end(), ' ', '_');
                             return name;
                         });

TEST(Lights, closedForms) {
    const ShapePtr rectangle = makeRectangle(Transform(), false);
    EXPECT_NEAR(test::areaCase("", rectangle, makeConstantTexture(Rgb(2.0f))).light->power(), 2 * kPi * 4,
                1e-4);
    EXPECT_NEAR(makePointLight({{0, 0, 0}, Rgb(2.0f)})->power(), 8 * kPi, 1e-4);
    // Without falloff a spot of 60 degrees fills a solid angle of 2 pi (1 - cos 60).
    EXPECT_NEAR(makeSpotLight({Transform(), Rgb(2.0f), 60, 60, nullptr})->power(), 2 * kPi, 1e-4);
    const auto at = [](const LightPtr& light, const Vec3f& x) {
        return light->connect(x, {0.3f, 0.4f})->value.x;
    };
    EXPECT_NEAR(at(makePointLight({{0, 0, 1}, Rgb(2.0f)}), {0, 0, 3}), 0.5, 1e-6);
    const LightPtr spot = makeSpotLight({Transform(), Rgb(2.0f), 40, 20, nullptr});
    const auto toward = [](double degrees) {
        const double a = degrees * std::numbers::pi / 180;
        return Vec3f(static_cast<float>(std::sin(a)), 0, static_cast<float>(std::cos(a)));
    };
    EXPECT_NEAR(at(spot, toward(10)), 2, 1e-5);
    EXPECT_NEAR(at(spot, toward(30)), 1, 1e-5);
    EXPECT_NEAR(at(spot, toward(39)), 0.1, 1e-4);
    EXPECT_FALSE(spot->connect(toward(41), {}));
    EXPECT_FALSE(spot->connect(toward(180), {}));
    // A projector's irradiance on the plane z = 1 is pi * scale * texture everywhere within its image.
    const LightPtr projector = makeProjector({Transform(), makeConstantTexture(Rgb(2.0f)), 3, 1, 2});
    for (const Vec3f& x : {Vec3f(0, 0, 1), Vec3f(0.9f, -0.4f, 1)}) {
        const auto c = projector->connect(x, {});
        EXPECT_NEAR(c->value.x * std::abs(c->wi.z), 6 * kPi, 1e-3);
    }
    EXPECT_FALSE(projector->connect({1.1f, 0, 1}, {}));
    EXPECT_FALSE(projector->connect({0, 0.6f, 1}, {}));
    EXPECT_FALSE(projector->connect({0, 0, -1}, {}));
}

TEST(Lights, projectorShowsTheTextureAsACameraSeesIt) {
    // Bright first texel of the first row: the upper left of the image, camera space +x +y.
    BitmapTextureParameters p;
    p.width = p.height = 2;
    p.filter = BitmapTextureParameters::Filter::Nearest;
    p.pixels =
        std::make_shared<const std::vector<float>>(std::vector<float>{1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    const LightPtr projector = makeProjector({Transform(), makeBitmapTexture(p), 1, 1, 1});
    EXPECT_TRUE(projector->connect({0.5f, 0.5f, 1}, {}));
    EXPECT_FALSE(projector->connect({-0.5f, 0.5f, 1}, {}));
    EXPECT_FALSE(projector->connect({0.5f, -0.5f, 1}, {}));
}

TEST(Lights, areaLightsAreOneSided) {
    const LightCase c = test::areaCase("", makeRectangle(Transform(), false), makeConstantTexture(Rgb(1.0f)));
    EXPECT_TRUE(c.light->connect({0.2f, 0, 1}, {0.5f, 0.5f}));
    EXPECT_FALSE(c.light->connect({0.2f, 0, -1}, {0.5f, 0.5f}));
    EXPECT_FALSE(c.light->connect({0.2f, 0, 0}, {0.5f, 0.5f}));
    EXPECT_EQ(c.light->shape(), c.shape.get());
}

/// A light in one plane refuses points behind it before it samples: never one that a sample could reach, as
/// near to the plane and as far away as it may be; and nearly all that lie clearly behind.
TEST(Lights, flatAreaLightsReachAllThatIsBeforeThem) {
    CounterRng rng(hashKey(77));
    for (const float size : {1e-3f, 1.0f, 300.0f})
        for (int orientation = 0; orientation < 12; ++orientation) {
            const Vec3f axis = warp::squareToSphere(rng.next2D());
            const Transform map = Transform::translate(warp::squareToSphere(rng.next2D()) * (5 * size)) *
                                  Transform::rotate(axis, 360 * rng.next1D()) *
                                  Transform::scale(Vec3f(size, 0.3f * size, size));
            const LightCase c =
                test::areaCase("", makeRectangle(map, orientation % 2 == 0), makeConstantTexture(Rgb(1.0f)));
            int reached = 0;
            for (int i = 0; i < 2000; ++i) {
                const ShapeSample foot = c.shape->sampleArea(rng.next2D());
                const float height = size * std::pow(10.0f, 4 * rng.next1D() - 3);  // 1e-3 to 10 sizes
                const Vec3f aside = warp::squareToSphere(rng.next2D()) * (size * 20 * rng.next1D());
                const Vec3f x =
                    foot.si.p + (aside - foot.si.ng * dot(aside, foot.si.ng)) + foot.si.ng * height;
                const Vec2f u = rng.next2D();
                const bool before = dot(foot.si.ng, x - c.shape->sampleArea(u).si.p) > 0;
                reached += before;
                EXPECT_EQ(c.light->connect(x, u).has_value(), before)
                    << "size " << size << ", height " << height;
                EXPECT_FALSE(c.light->connect(x - foot.si.ng * (3 * height), u))
                    << "behind by " << 2 * height;
            }
            EXPECT_GT(reached, 1900);
        }
}

TEST(Lights, rejectWhatMakesNoSense) {
    EXPECT_THROW(makePointLight({{0, 0, 0}, {1, -1, 1}}), Error);
    EXPECT_THROW(makeConstantLight({{1, kInfinity, 1}}), Error);
    EXPECT_THROW(makeDirectionalLight({{0, 0, 0}, Rgb(1.0f)}), Error);
    EXPECT_THROW(makeSpotLight({Transform(), Rgb(1.0f), 0, 0, nullptr}), Error);
    EXPECT_THROW(makeSpotLight({Transform(), Rgb(1.0f), 20, 30, nullptr}), Error);
    EXPECT_THROW(makeSpotLight({Transform(), Rgb(1.0f), 95, 30, test::patchyTexture(true)}), Error);
    EXPECT_THROW(makeEnvironmentMap({}), Error);
}

}  // namespace
}  // namespace metrolux::core
