/// Chi-square tests: what connect() and sampleRay() pick is distributed as the densities that MIS weights are
/// made from.

#include "base/frame.h"
#include "chi_square.h"
#include "geometry/intersector.h"
#include "light_cases.h"

namespace metrolux::core {
namespace {

using test::chiSquare;
using test::kBounds;

constexpr float kTwoPi = 2 * kPi;

float turn(float y, float x) {
    const float t = std::atan2(y, x) / kTwoPi;
    return t < 0 ? t + 1 : t;
}

/// Directions to (share of the cone 1 - cos, turn) around an axis; density per solid angle times solidAngle.
struct ConeMap {
    Frame axes;
    float oneMinusCos = 2;
    float solidAngle() const { return kTwoPi * oneMinusCos; }
    Vec2f fromDirection(const Vec3f& w) const {
        const Vec3f d = axes.toLocal(w);
        // 1 - cos by the sine: keeps precision near the axis.
        const float sine2 = d.x * d.x + d.y * d.y;
        const float gap = d.z > 0 ? sine2 / (1 + d.z) : 1 - d.z;
        return {turn(d.y, d.x), gap / oneMinusCos};
    }
    Vec3f direction(const Vec2f& p) const {
        const float z = 1 - p.y * oneMinusCos, r = safeSqrt(1 - z * z);
        return normalize(axes.toWorld({r * std::cos(kTwoPi * p.x), r * std::sin(kTwoPi * p.x), z}));
    }
};

Frame axesOf(const Transform& t) { return {t.vector({1, 0, 0}), t.vector({0, 1, 0}), t.vector({0, 0, 1})}; }

/// Directions of a point-like light against the densities that connect() reports for points all around.
void checkPointLike(const LightPtr& light, const ConeMap& map, const Vec3f& position, uint64_t seed,
                    const test::ChiSquareOptions& options = {}) {
    chiSquare(
        [&](CounterRng& rng) -> std::optional<Vec2f> {
            const auto ray = light->sampleRay(rng.next2D(), rng.next2D());
            if (!ray) return std::nullopt;
            return map.fromDirection(ray->direction);
        },
        [&](const Vec2f& p) {
            const auto c = light->connect(position + map.direction(p) * 1.7f, {});
            return c ? double(c->pdfDirection) * map.solidAngle() : 0.0;
        },
        seed, options);
}

TEST(LightSampling, pointAndSpots) {
    const Transform t = test::tilted();
    const Vec3f origin = t.point(Vec3f(0.0f));
    checkPointLike(makePointLight({origin, Rgb(1.0f)}), {axesOf(t), 2}, origin, 1);
    for (const float cutoff : {3.0f, 40.0f, 150.0f}) {
        const float gap = 2 * sqr(std::sin(radians(cutoff) / 2));
        checkPointLike(makeSpotLight({t, Rgb(1.0f), cutoff, 0.7f * cutoff, nullptr}), {axesOf(t), gap},
                       origin, 2);
    }
}

TEST(LightSampling, goniometric) {
    const Transform t = test::tilted();
    const Vec3f origin = t.point(Vec3f(0.0f));
    const PhotometricWeb spot{{0, 10, 12}, {0}, {5, 5, 0}},
        half{{0, 90, 180}, {0, 45, 90, 135, 180}, {1, 2, 0, 1, 4, 0, 1, 0, 0, 1, 3, 1, 1, 1, 1}};
    // The density is constant over half a degree, which the quadrature has to resolve.
    const auto gap = [](float degrees) { return 2 * sqr(std::sin(radians(degrees) / 2)); };
    for (const auto& [web, cone] : {std::pair(spot, 12.0f), {half, 180.0f}, {test::patchyWeb(), 110.0f}}) {
        SCOPED_TRACE(cone);
        checkPointLike(makeGoniometricLight({t, Rgb(1.0f), web}), {axesOf(t), gap(cone)}, origin, 4,
                       {.quadrature = 24});
    }
}

TEST(LightSampling, projector) {
    const Transform t = test::tilted();
    const float halfWidth = 0.6f, halfHeight = halfWidth * 0.75f;
    for (const bool nearest : {false, true}) {
        const LightPtr light = makeProjector({t, test::patchyTexture(nearest), 1, halfWidth, 4.0f / 3});
        const Frame axes = axesOf(t);
        const Vec3f origin = t.point(Vec3f(0.0f));
        chiSquare(
            [&](CounterRng& rng) -> std::optional<Vec2f> {
                const auto ray = light->sampleRay(rng.next2D(), rng.next2D());
                if (!ray) return std::nullopt;
                const Vec3f d = axes.toLocal(ray->direction);
                return Vec2f(0.5f + 0.5f * d.x / (d.z * halfWidth), 0.5f + 0.5f * d.y / (d.z * halfHeight));
            },
            [&](const Vec2f& p) {
                const Vec3f d((2 * p.x - 1) * halfWidth, (2 * p.y - 1) * halfHeight, 1);
                const auto c = light->connect(origin + axes.toWorld(d), {});
                const float cosine = 1 / d.length();
                return c ? double(c->pdfDirection) * 4 * halfWidth * halfHeight * cosine * cosine * cosine
                         : 0.0;
            },
            3, {.width = 16, .height = 12});
    }
}

/// Position (uv) and direction of a light's rays, on shapes whose uv are proportional to area.
void checkAreaRays(const test::LightCase& c, const std::function<SurfaceInteraction(const Vec2f&)>& at,
                   uint64_t seed) {
    SCOPED_TRACE(c.name);
    const float area = c.shape->area();
    chiSquare(
        [&](CounterRng& rng) -> std::optional<Vec2f> {
            const auto ray = c.light->sampleRay(rng.next2D(), rng.next2D());
            if (!ray) return std::nullopt;
            return ray->surface.uv;
        },
        [&](const Vec2f& uv) {
            const SurfaceInteraction si = at(uv);
            if (isBlack(c.light->radiance(si, si.ng))) return 0.0;  // no ray starts there
            return double(c.light->densities(si.p + si.ng, si).pdfPosition) * area;
        },
        seed, {.width = 12, .height = 12});
    chiSquare(  // (cos^2, turn): density pdf * pi / cos
        [&](CounterRng& rng) -> std::optional<Vec2f> {
            std::optional<EndpointRay> ray;  // of those that leave a point that is not black
            while (!ray) ray = c.light->sampleRay(rng.next2D(), rng.next2D());
            const Vec3f d = Frame::fromNormal(ray->ng).toLocal(ray->direction);
            return Vec2f(d.z * d.z, turn(d.y, d.x));
        },
        [&](const Vec2f& p) {
            const SurfaceInteraction si = at({0.8f, 0.4f});
            const float z = std::sqrt(p.x), r = std::sqrt(1 - p.x);
            const Vec3f w =
                Frame::fromNormal(si.ng).toWorld({r * std::cos(kTwoPi * p.y), r * std::sin(kTwoPi * p.y), z});
            return double(c.light->densities(si.p + w, si).pdfDirection) * kPi / z;
        },
        seed + 1);
}

/// The direction toward an area light: by uv, where the shape has a point for each uv.
void checkAreaConnect(const test::LightCase& c, const std::function<SurfaceInteraction(const Vec2f&)>& at,
                      const Vec3f& x, uint64_t seed) {
    SCOPED_TRACE(c.name);
    const Intersector intersector({c.shape}, {});
    const float area = c.shape->area();
    chiSquare(
        [&](CounterRng& rng) -> std::optional<Vec2f> {
            const auto e = c.light->connect(x, rng.next2D());
            SurfaceInteraction si;
            if (!e || !intersector.intersect({x, e->wi, kInfinity}, si)) return std::nullopt;
            return si.uv;
        },
        [&](const Vec2f& uv) {
            const SurfaceInteraction si = at(uv);
            const Vec3f d = x - si.p;
            if (isBlack(c.light->radiance(si, normalize(d)))) return 0.0;
            const float cosine = dot(si.ng, normalize(d));
            return double(c.light->densities(x, si).connect) * cosine / lengthSquared(d) * area;
        },
        seed, {.width = 12, .height = 12, .quadrature = 16});
}

TEST(LightSampling, rectangles) {
    const Transform t = test::tilted() * Transform::scale({0.7f, 0.3f, 1});
    const auto at = [&](const Vec2f& uv) {
        SurfaceInteraction si;
        si.p = t.point({2 * uv.x - 1, 2 * uv.y - 1, 0});
        si.ng = si.ns = normalize(t.normal({0, 0, 1}));
        si.uv = uv;
        return si;
    };
    const Vec3f x = t.point({0.3f, 1.2f, 0.9f});
    uint64_t seed = 100;
    for (const TexturePtr& texture :
         {makeConstantTexture(Rgb(2.0f)), test::patchyTexture(true), test::patchyTexture(false)}) {
        const test::LightCase c = test::areaCase("rectangle", makeRectangle(t, false), texture);
        checkAreaRays(c, at, seed += 10);
        checkAreaConnect(c, at, x, seed += 10);
    }
}

TEST(LightSampling, spheres) {
    const float radius = 0.6f;
    const Vec3f center = test::tilted().point(Vec3f(0.0f));
    for (const bool inside : {false, true}) {
        const test::LightCase c =
            test::areaCase("sphere", makeSphere(test::tilted(), Vec3f(0.0f), radius, inside),
                           makeConstantTexture(Rgb(2.0f)));
        const Intersector intersector({c.shape}, {});
        for (const float distance :
             inside ? std::vector<float>{0.1f, 0.5f} : std::vector<float>{0.61f, 0.9f, 30.0f}) {
            SCOPED_TRACE(distance);
            const Vec3f x = center + normalize(Vec3f(1, -2, 0.5f)) * distance;
            ConeMap map{Frame::fromNormal(normalize(center - x)), 2};
            if (!inside) map.oneMinusCos = 1 - safeSqrt(1 - sqr(radius / distance));
            if (distance > 10)
                map.oneMinusCos = 0.5f * sqr(radius / distance) * (1 + 0.25f * sqr(radius / distance));
            chiSquare(
                [&](CounterRng& rng) -> std::optional<Vec2f> {
                    const auto e = c.light->connect(x, rng.next2D());
                    if (!e) return std::nullopt;
                    return map.fromDirection(e->wi);
                },
                [&](const Vec2f& p) {
                    SurfaceInteraction si;
                    if (!intersector.intersect({x, map.direction(p), kInfinity}, si)) return 0.0;
                    return double(c.light->densities(x, si).connect) * map.solidAngle();
                },
                200, {.width = 10, .height = 10});
        }
    }
}

/// Directions of environments in the coordinates of the map; both ends of the ray.
TEST(LightSampling, environments) {
    const EnvironmentMapParameters p = test::patchyEnvironment();
    const Frame axes = axesOf(p.toWorld);
    // As the table's cells lie: u shifted by half a texel.
    const auto toSquare = [&](const Vec3f& w) {
        const Vec3f d = axes.toLocal(w);
        const float s = turn(d.x, -d.z) - 0.5f / 8;
        return Vec2f(s - std::floor(s), std::atan2(std::hypot(d.x, d.z), d.y) / kPi);
    };
    const auto toDirection = [&](const Vec2f& q) {
        const float phi = kTwoPi * (q.x + 0.5f / 8), theta = kPi * q.y;
        return axes.toWorld(
            {std::sin(phi) * std::sin(theta), std::cos(theta), -std::cos(phi) * std::sin(theta)});
    };
    for (const LightPtr& light : {makeEnvironmentMap(p), makeConstantLight({Rgb(2.0f)})}) {
        light->setSceneBounds(kBounds);
        const Vec3f x(0.3f, 0.1f, 0.2f);
        const auto density = [&](const Vec2f& q, bool connect) {
            const EndpointDensities d = light->environmentDensities(x, toDirection(q));
            if (isBlack(light->environmentRadiance(toDirection(q)))) return 0.0;
            return double(connect ? d.connect : d.pdfDirection) * 2 * kPi * kPi * std::sin(kPi * q.y);
        };
        chiSquare(
            [&](CounterRng& rng) -> std::optional<Vec2f> {
                const auto e = light->connect(x, rng.next2D());
                if (!e) return std::nullopt;
                return toSquare(e->wi);
            },
            [&](const Vec2f& q) { return density(q, true); }, 300,
            {.width = 32, .height = 16, .quadrature = 16});
        chiSquare(
            [&](CounterRng& rng) -> std::optional<Vec2f> {
                const auto ray = light->sampleRay(rng.next2D(), rng.next2D());
                if (!ray) return std::nullopt;
                return toSquare(-ray->direction);
            },
            [&](const Vec2f& q) { return density(q, false); }, 301,
            {.width = 32, .height = 16, .quadrature = 16});
    }
}

/// Directions by azimuth and angle from the zenith, or within the sun's cone; both ends of the ray.
TEST(LightSampling, skyAndSun) {
    SunSkyParameters low = test::skyOnly(), real = test::wideSun();
    low.turbidity = 2;
    low.stretch = 1;
    real.sunDirection = normalize(Vec3f(1, 1.5f, 0.2f));
    real.sunAperture = 0.5358f;
    SunSkyParameters realSun = real;
    realSun.skyScale = 0;
    const auto both = [](const LightPtr& light, const std::function<Vec2f(const Vec3f&)>& toSquare,
                         const std::function<Vec3f(const Vec2f&)>& toDirection,
                         const std::function<double(const Vec2f&)>& jacobian) {
        light->setSceneBounds(kBounds);
        const Vec3f x(0.3f, 0.1f, 0.2f);
        for (const bool connect : {true, false}) {
            chiSquare(
                [&](CounterRng& rng) -> std::optional<Vec2f> {
                    const Vec2f u = rng.next2D();
                    if (connect) {
                        const auto e = light->connect(x, u);
                        if (!e) return std::nullopt;
                        return toSquare(e->wi);
                    }
                    const auto ray = light->sampleRay(rng.next2D(), u);
                    if (!ray) return std::nullopt;
                    return toSquare(-ray->direction);
                },
                [&](const Vec2f& q) {
                    const Vec3f w = toDirection(q);
                    if (isBlack(light->environmentRadiance(w))) return 0.0;
                    const EndpointDensities d = light->environmentDensities(x, w);
                    return double(connect ? d.connect : d.pdfDirection) * jacobian(q);
                },
                connect ? 310 : 311, {.width = 32, .height = 16, .quadrature = 16});
        }
    };
    for (const SunSkyParameters& p : {low, test::skyOnly(), test::wideSun()}) {
        const Frame axes = Frame::fromNormal(p.up);
        const double size = std::numbers::pi / 2 * p.stretch;  // the table's cells are thin bands of theta
        both(
            makeSunSky(p),
            [&](const Vec3f& w) {
                const Vec3f d = axes.toLocal(w);
                return Vec2f(turn(d.y, d.x), std::min(static_cast<float>(std::acos(d.z) / size), 1.0f));
            },
            [&](const Vec2f& q) {
                const double theta = size * q.y, phi = 2 * std::numbers::pi * q.x, r = std::sin(theta);
                return axes.toWorld({static_cast<float>(r * std::cos(phi)),
                                     static_cast<float>(r * std::sin(phi)),
                                     static_cast<float>(std::cos(theta))});
            },
            [&](const Vec2f& q) { return 2 * std::numbers::pi * size * std::sin(size * q.y); });
    }
    const ConeMap cone{Frame::fromNormal(realSun.sunDirection),
                       2 * sqr(std::sin(radians(realSun.sunAperture) / 4))};
    both(
        makeSunSky(realSun), [&](const Vec3f& w) { return cone.fromDirection(w); },
        [&](const Vec2f& q) {
            const float gap = q.y * cone.oneMinusCos, r = std::sqrt(gap * (2 - gap));
            return normalize(
                cone.axes.toWorld({r * std::cos(kTwoPi * q.x), r * std::sin(kTwoPi * q.x), 1 - gap}));
        },
        [&](const Vec2f&) { return cone.solidAngle(); });
}

TEST(LightSampling, raysOfInfiniteLightsCoverTheScene) {
    const LightPtr sunSky = makeSunSky(test::wideSun());
    const LightPtr directional = makeDirectionalLight({{0.3f, -2, 0.5f}, Rgb(1.0f)});
    const LightPtr environment = makeEnvironmentMap(test::patchyEnvironment());
    const LightPtr constant = makeConstantLight({Rgb(1.0f)});
    for (const LightPtr& light : {directional, constant, environment, sunSky}) {
        light->setSceneBounds(kBounds);
        const float diskArea = kPi * sqr(kBounds.radius);
        // (share of the disk's area, turn) around the ray's direction.
        chiSquare(
            [&](CounterRng& rng) -> std::optional<Vec2f> {
                Vec2f uPosition = rng.next2D();
                std::optional<EndpointRay> ray;
                while (!ray) ray = light->sampleRay(uPosition, rng.next2D());
                const Vec3f local = Frame::fromNormal(ray->direction).toLocal(ray->origin - kBounds.center);
                EXPECT_LE(local.z, -kBounds.radius * 0.9999f) << "starts before the scene";
                EXPECT_NEAR(ray->pdfPosition * diskArea, 1, 1e-5);
                return Vec2f((local.x * local.x + local.y * local.y) / sqr(kBounds.radius),
                             turn(local.y, local.x));
            },
            [](const Vec2f&) { return 1.0; }, 400);
    }
}

TEST(EnvironmentMap, orientation) {
    // One bright texel; radiance peaks in its direction, and falls to zero one texel away.
    EnvironmentMapParameters p;
    p.width = 8;
    p.height = 5;
    p.pixels.assign(40, Rgb(0.0f));
    p.pixels[2 * 8 + 2] = {8, 4, 2};
    const LightPtr light = makeEnvironmentMap(p);
    const auto direction = [](double u, double v) {
        const double phi = 2 * std::numbers::pi * u, theta = std::numbers::pi * v;
        return Vec3f(static_cast<float>(std::sin(phi) * std::sin(theta)), static_cast<float>(std::cos(theta)),
                     static_cast<float>(-std::cos(phi) * std::sin(theta)));
    };
    test::expectClose(light->environmentRadiance(direction(2.5 / 8, 2.0 / 4)), Rgb(8, 4, 2), 1e-5, "center");
    test::expectClose(light->environmentRadiance(direction(3.0 / 8, 2.0 / 4)), Rgb(4, 2, 1), 1e-5,
                      "half a texel on");
    test::expectClose(light->environmentRadiance(direction(2.5 / 8, 1.5 / 4)), Rgb(4, 2, 1), 1e-5,
                      "half a row up");
    EXPECT_LT(maxComponent(light->environmentRadiance(direction(3.5 / 8, 2.0 / 4))), 1e-4f);
    EXPECT_EQ(light->environmentRadiance({0, 1, 0}), Rgb(0.0f));

    // u = 1/4 is +x, u = 3/4 is -x, u = 0 is -z; the first row is +y.
    EnvironmentMapParameters q;
    q.width = 2;
    q.height = 3;
    q.pixels = {Rgb(1.0f), Rgb(1.0f), Rgb(2.0f), Rgb(3.0f), Rgb(4.0f), Rgb(4.0f)};
    const LightPtr axes = makeEnvironmentMap(q);
    EXPECT_NEAR(axes->environmentRadiance({0, 1, 0}).x, 1, 1e-4);
    EXPECT_NEAR(axes->environmentRadiance({0, -1, 0}).x, 4, 1e-4);
    EXPECT_NEAR(axes->environmentRadiance({1, 0, 0}).x, 2, 1e-4);
    EXPECT_NEAR(axes->environmentRadiance({-1, 0, 0}).x, 3, 1e-4);
    EXPECT_NEAR(axes->environmentRadiance({0, 0, -1}).x, 2.5, 1e-4);

    // to_world turns local +x to world +z.
    q.toWorld = Transform::rotate({0, 1, 0}, -90);
    EXPECT_NEAR(makeEnvironmentMap(q)->environmentRadiance({0, 0, 1}).x, 2, 1e-4);
}

}  // namespace
}  // namespace metrolux::core
