/// Cameras: sampled rays, connections and their densities are those of one map from the film to directions;
/// Mitsuba 3's orientation, field of view, crop window and principal point.

#include "base/error.h"
#include "base/frame.h"
#include "chi_square.h"
#include "endpoint/wide_cameras.h"

namespace metrolux::core {
namespace {

using test::chiSquare;
using test::expectClose;

struct CameraCase {
    PerspectiveParameters parameters;
    FilmWindow window;
};

std::vector<CameraCase> perspectiveCases() {
    std::vector<CameraCase> cases;
    const FilmWindow landscape{640, 360, 0, 0, 640, 360}, portrait{300, 500, 0, 0, 300, 500};
    const FilmWindow crop{640, 360, 100, 50, 200, 120};
    for (const FovAxis axis : {FovAxis::X, FovAxis::Y, FovAxis::Diagonal, FovAxis::Smaller, FovAxis::Larger})
        for (const FilmWindow& window : {landscape, portrait, crop})
            for (const float aperture : {0.0f, 0.3f}) {
                CameraCase c;
                c.parameters.toWorld = Transform::lookAt({1, 2, 3}, {0.4f, -0.3f, 0.2f}, {0.1f, 1, 0.3f});
                c.parameters.fov = 55;
                c.parameters.axis = axis;
                c.parameters.nearClip = 0.5f;
                c.parameters.apertureRadius = aperture;
                c.parameters.focusDistance = 4;
                if (axis == FovAxis::Diagonal) {
                    c.parameters.principalOffsetX = 0.1f;
                    c.parameters.principalOffsetY = -0.2f;
                }
                c.window = window;
                cases.push_back(c);
            }
    cases.push_back(cases.front());  // mirrored, as some exporters write
    cases.back().parameters.toWorld = cases.back().parameters.toWorld * Transform::scale({-1, 1, 1});
    return cases;
}

Vec2f rasterIn(const FilmWindow& w, const Vec2f& u) {
    return {static_cast<float>(w.x) + u.x * static_cast<float>(w.width),
            static_cast<float>(w.y) + u.y * static_cast<float>(w.height)};
}

/// For all cameras: a point on a sampled ray connects back to the same raster position with the same
/// densities.
void checkRoundTrip(const Camera& camera, uint64_t seed) {
    CounterRng rng(seed);
    const float pixels = static_cast<float>(camera.window().pixelCount());
    for (int i = 0; i < 500; ++i) {
        const Vec2f uLens = rng.next2D(), raster = rasterIn(camera.window(), rng.next2D());
        const std::optional<EndpointRay> ray = camera.sampleRay(uLens, raster);
        if (!ray) continue;  // outside of a fisheye's circle
        EXPECT_NEAR(ray->direction.length(), 1, 1e-5);
        EXPECT_EQ(ray->weight, Rgb(1.0f));
        EXPECT_EQ(ray->cosine, 1);
        EXPECT_EQ(ray->ng, Vec3f(0.0f));
        const Vec3f x = ray->origin + ray->direction * (0.01f + 6 * rng.next1D());
        const std::optional<EndpointConnection> c = camera.connect(x, uLens);
        if (!c) {  // rounding at the border
            const Vec2f size(static_cast<float>(camera.window().fullWidth),
                             static_cast<float>(camera.window().fullHeight));
            EXPECT_TRUE(raster.x < 0.01f || raster.y < 0.01f || raster.x > size.x - 0.01f ||
                        raster.y > size.y - 0.01f);
            continue;
        }
        EXPECT_NEAR(c->filmPosition.x, raster.x, 0.02);
        EXPECT_NEAR(c->filmPosition.y, raster.y, 0.02);
        EXPECT_NEAR((c->wi + ray->direction).length(), 0, 1e-4);
        EXPECT_NEAR((c->point - ray->origin).length(), 0, 1e-4 * (1 + x.length()))
            << "visibility ends where the ray begins";
        expectClose(c->pdfPosition, ray->pdfPosition, 1e-5, "density of the position");
        expectClose(c->pdfDirection, ray->pdfDirection, 1e-3, "density of the direction");
        EXPECT_EQ(c->pdf, 1);
        EXPECT_EQ(c->cosine, 1);
        EXPECT_EQ(c->value.x, c->value.y);
        EXPECT_EQ(c->value.x, c->value.z);
        if (camera.isInfinite()) {
            expectClose(c->value.x, c->pdfPosition * pixels, 1e-5, "value");
        } else {
            const Vec3f center = camera.projectionCenter(ray->origin, ray->direction);
            expectClose(c->distance, (x - center).length(), 1e-4, "distance from the lens");
            expectClose(c->value.x * sqr(c->distance), c->pdfDirection * pixels, 1e-5, "value");
        }
    }
}

/// A row from the left times the matrix, made inhomogeneous.
Vec3f projected(const std::array<float, 16>& m, const Vec3f& p) {
    double r[4];
    for (size_t c = 0; c < 4; ++c)
        r[c] = double(p.x) * double(m[c]) + double(p.y) * double(m[4 + c]) + double(p.z) * double(m[8 + c]) +
               double(m[12 + c]);
    return {static_cast<float>(r[0] / r[3]), static_cast<float>(r[1] / r[3]),
            static_cast<float>(r[2] / r[3])};
}

/// Points on rays through the middle of the lens are where OpenEXR's definitions of the matrices say.
void checkMatrices(const Camera& camera) {
    const Camera::Matrices matrices = camera.matrices().value();
    const FilmWindow& w = camera.window();
    CounterRng rng(3);
    for (int i = 0; i < 100; ++i) {
        const Vec2f raster = rasterIn(w, rng.next2D());
        const auto ray = camera.sampleRay(Vec2f(0.5f), raster);
        const Vec3f p = ray->origin + ray->direction * (1 + 10 * rng.next1D());
        const Vec3f ndc = projected(matrices.worldToNdc, p);
        EXPECT_NEAR(ndc.x, raster.x / static_cast<float>(w.fullWidth), 1e-5f);
        EXPECT_NEAR(ndc.y, raster.y / static_cast<float>(w.fullHeight), 1e-5f);
        // Rigid for cameras that do not scale; in front is positive, right and up are as in the image.
        const Vec3f local = projected(matrices.worldToCamera, p);
        EXPECT_GT(local.z, 0);
        const auto moved = camera.sampleRay(Vec2f(0.5f), raster + Vec2f(5, 0));
        const auto lower = camera.sampleRay(Vec2f(0.5f), raster + Vec2f(0, 5));
        const auto at = [&](const EndpointRay& r) {
            return projected(matrices.worldToCamera, r.origin + r.direction * 10.0f);
        };
        EXPECT_GT(at(*moved).x, at(*ray).x);
        EXPECT_LT(at(*lower).y, at(*ray).y);
    }
}

TEST(Camera, matricesAreThoseOfOpenExr) {
    for (const CameraCase& c : perspectiveCases())
        checkMatrices(*makePerspectiveCamera(c.parameters, c.window));
    OrthographicParameters p;
    p.toWorld =
        Transform::lookAt({1, 2, 3}, {0.4f, -0.3f, 0.2f}, {0.1f, 1, 0.3f}) * Transform::scale({2, 3, 1});
    for (const FilmWindow& window :
         {FilmWindow{640, 360, 0, 0, 640, 360}, FilmWindow{640, 360, 100, 50, 200, 120}})
        checkMatrices(*makeOrthographicCamera(p, window));
}

TEST(PerspectiveCamera, connectionsFindTheRastersOfRays) {
    uint64_t seed = 1;
    for (const CameraCase& c : perspectiveCases())
        checkRoundTrip(*makePerspectiveCamera(c.parameters, c.window), ++seed);
}

/// The density of directions against the directions themselves, on the plane at distance 1, whose extent is
/// computed here from the field of view alone.
TEST(PerspectiveCamera, directionsHaveTheirDensity) {
    uint64_t seed = 50;
    for (const CameraCase& c : perspectiveCases()) {
        if (c.parameters.toWorld.determinant3() < 0) continue;
        const CameraPtr camera = makePerspectiveCamera(c.parameters, c.window);
        const double w = c.window.fullWidth, h = c.window.fullHeight,
                     t = std::tan(55.0 / 360 * std::numbers::pi);
        const double side = c.parameters.axis == FovAxis::X          ? w
                            : c.parameters.axis == FovAxis::Y        ? h
                            : c.parameters.axis == FovAxis::Diagonal ? std::hypot(w, h)
                            : c.parameters.axis == FovAxis::Smaller  ? std::min(w, h)
                                                                     : std::max(w, h);
        const float pixel = static_cast<float>(2 * t / side);
        const Transform m = c.parameters.toWorld;
        const Frame axes{m.vector({1, 0, 0}), m.vector({0, 1, 0}), m.vector({0, 0, 1})};
        const Vec2f uLens(0.31f, 0.85f);
        const Vec3f lens = camera->projectionCenter(camera->sampleRay(uLens, {0, 0})->origin,
                                                    camera->sampleRay(uLens, {0, 0})->direction);
        const Vec3f offset = axes.toLocal(lens - camera->position());
        // Where the middle of the image lies on the plane at distance 1 in front of the lens point.
        const float x0 = static_cast<float>(-c.parameters.principalOffsetX * w) * pixel - offset.x / 4;
        const float y0 = static_cast<float>(-c.parameters.principalOffsetY * h) * pixel - offset.y / 4;
        const FilmWindow& f = c.window;
        const float left = x0 + pixel * static_cast<float>(w / 2 - f.x),
                    top = y0 + pixel * static_cast<float>(h / 2 - f.y);
        const float width = pixel * static_cast<float>(f.width),
                    height = pixel * static_cast<float>(f.height);
        chiSquare(
            [&](CounterRng& rng) -> std::optional<Vec2f> {
                const Vec3f d = axes.toLocal(camera->sampleRay(uLens, rasterIn(f, rng.next2D()))->direction);
                return Vec2f((left - d.x / d.z) / width, (top - d.y / d.z) / height);
            },
            [&](const Vec2f& p) {
                const Vec3f d(left - p.x * width, top - p.y * height, 1);
                const auto e = camera->connect(lens + axes.toWorld(d) * 3.0f, uLens);
                const float cosine = 1 / d.length();
                return e ? double(e->pdfDirection) * width * height * cosine * cosine * cosine : 0.0;
            },
            ++seed, {.samples = 20000, .quadrature = 4});
    }
}

TEST(PerspectiveCamera, orientationAndFieldOfView) {
    PerspectiveParameters p;
    p.toWorld = Transform::lookAt({0, 0, 0}, {0, 0, 1}, {0, 1, 0});
    p.fov = 90;
    const FilmWindow window{400, 200, 0, 0, 400, 200};
    const auto direction = [&](const Vec2f& raster) {
        const Vec3f d = makePerspectiveCamera(p, window)->sampleRay({}, raster)->direction;
        return d * (1 / d.z);
    };
    // Raster x grows to the right of the image, where camera x falls; raster y grows downward.
    EXPECT_NEAR((direction({0, 0}) - Vec3f(1, 0.5f, 1)).length(), 0, 1e-5);
    EXPECT_NEAR((direction({400, 200}) - Vec3f(-1, -0.5f, 1)).length(), 0, 1e-5);
    EXPECT_NEAR((direction({200, 100}) - Vec3f(0, 0, 1)).length(), 0, 1e-5);
    // Mitsuba adds the principal point's offset to the position on the film.
    p.principalOffsetX = 0.25f;
    EXPECT_NEAR(direction({100, 100}).x, 0, 1e-5);
    p.principalOffsetX = 0;
    p.axis = FovAxis::Y;
    EXPECT_NEAR(direction({200, 0}).y, 1, 1e-5);
    EXPECT_NEAR(perspectiveHalfWidth(46.792f, FovAxis::Diagonal, 1.5f), 36.0 / 2 / 50,
                1e-4);  // 50 mm on 36 x 24
    EXPECT_THROW(perspectiveHalfWidth(180, FovAxis::X, 1), Error);
}

TEST(PerspectiveCamera, whatLiesOutside) {
    PerspectiveParameters p;
    p.toWorld = Transform::lookAt({0, 0, 0}, {0, 0, 1}, {0, 1, 0});
    p.fov = 90;
    p.nearClip = 0.5f;
    const CameraPtr camera = makePerspectiveCamera(p, {400, 200, 100, 50, 40, 20});
    EXPECT_TRUE(camera->connect({0, 0, 2}, {})) << "outside the crop window, but within the image";
    EXPECT_FALSE(camera->connect({2.1f, 0, 2}, {})) << "outside the image";
    EXPECT_FALSE(camera->connect({0, 1.1f, 2}, {})) << "outside the image";
    EXPECT_FALSE(camera->connect({0, 0, -2}, {})) << "behind";
    EXPECT_FALSE(camera->connect({0.1f, 0, 0.49f}, {})) << "before the near clipping plane";
    EXPECT_TRUE(camera->connect({0.1f, 0, 0.51f}, {}));
    EXPECT_NEAR(camera->pixelFootprint(3), 3 * 2.0 / 400, 1e-6);
    EXPECT_THROW(makePerspectiveCamera(p, {400, 200, 0, 0, 0, 20}), Error);
    p.apertureRadius = -1;
    EXPECT_THROW(makePerspectiveCamera(p, {400, 200, 0, 0, 40, 20}), Error);
}

TEST(ThinLens, focusesAndCoversItsLens) {
    PerspectiveParameters p;
    p.toWorld = Transform::lookAt({1, 2, 3}, {0.4f, -0.3f, 0.2f}, {0.1f, 1, 0.3f});
    p.apertureRadius = 0.3f;
    p.focusDistance = 4;
    const CameraPtr camera = makePerspectiveCamera(p, {640, 360, 0, 0, 640, 360});
    p.apertureRadius = 0;
    const CameraPtr pinhole = makePerspectiveCamera(p, {640, 360, 0, 0, 640, 360});
    const Vec3f axis = p.toWorld.vector({0, 0, 1});
    CounterRng rng(5);
    for (int i = 0; i < 100; ++i) {
        const Vec2f raster(640 * rng.next1D(), 360 * rng.next1D());
        const auto a = pinhole->sampleRay({}, raster), b = camera->sampleRay(rng.next2D(), raster);
        const auto atFocus = [&](const EndpointRay& r) {
            const float depth = dot(r.origin - camera->position(), axis);
            return r.origin + r.direction * ((4 - depth) / dot(r.direction, axis));
        };
        EXPECT_NEAR((atFocus(*a) - atFocus(*b)).length(), 0, 1e-4);
    }
    const Frame axes{p.toWorld.vector({1, 0, 0}), p.toWorld.vector({0, 1, 0}), axis};
    chiSquare(
        [&](CounterRng& random) -> std::optional<Vec2f> {
            const auto ray = camera->sampleRay(random.next2D(), {200, 100});
            const Vec3f lens =
                axes.toLocal(camera->projectionCenter(ray->origin, ray->direction) - camera->position());
            EXPECT_NEAR(lens.z, 0, 1e-5);
            const float turns = std::atan2(lens.y, lens.x) / (2 * kPi);
            return Vec2f((lens.x * lens.x + lens.y * lens.y) / 0.09f, turns < 0 ? turns + 1 : turns);
        },
        [&](const Vec2f&) {
            return double(camera->sampleRay({}, {200, 100})->pdfPosition) * kPi * 0.09;
        },
        99);
}

WideCameraParameters wideParameters() {
    return {Transform::lookAt({1, 2, 3}, {0.4f, -0.3f, 0.2f}, {0.1f, 1, 0.3f}), 0.05f};
}

TEST(WideCameras, connectionsFindTheRastersOfRays) {
    const FilmWindow full{640, 320, 0, 0, 640, 320}, crop{640, 320, 100, 60, 200, 120};
    for (const FilmWindow& window : {full, crop}) {
        checkRoundTrip(*makePanoramaCamera(wideParameters(), window), 21);
        for (const float aperture : {30.0f, 180.0f, 350.0f})
            checkRoundTrip(*makeFisheyeCamera(wideParameters(), aperture, window), 22);
    }
}

/// A raster position in [0, 1]^2 of the window against the density of directions times the area that a
/// window's share of solid angle has: finite differences of directions, so that no Jacobian is written twice.
TEST(WideCameras, directionsHaveTheirDensity) {
    const FilmWindow window{64, 48, 8, 4, 40, 40};
    const auto check = [&](const Camera& camera) {
        CounterRng rng(5);
        for (int i = 0; i < 300; ++i) {
            const Vec2f raster = rasterIn(window, rng.next2D());
            const auto at = [&](float dx, float dy) { return camera.sampleRay({}, raster + Vec2f(dx, dy)); };
            constexpr float kStep = 0.02f;
            const auto a = at(-kStep, 0), b = at(kStep, 0), c = at(0, -kStep), d = at(0, kStep),
                       ray = at(0, 0);
            if (!a || !b || !c || !d || !ray) continue;
            const float solidAngle =
                cross(b->direction - a->direction, d->direction - c->direction).length() / sqr(2 * kStep);
            EXPECT_NEAR(ray->pdfDirection * solidAngle * float(window.pixelCount()), 1, 0.02) << raster;
        }
    };
    check(*makePanoramaCamera(wideParameters(), window));
    check(*makeFisheyeCamera(wideParameters(), 170, window));
    check(*makeFisheyeCamera(wideParameters(), 340, window));
}

TEST(WideCameras, orientation) {
    WideCameraParameters p;
    const CameraPtr panorama = makePanoramaCamera(p, {400, 200, 0, 0, 400, 200});
    const auto expectDirection = [](const Camera& camera, const Vec2f& raster, const Vec3f& expected) {
        EXPECT_NEAR((camera.sampleRay({}, raster)->direction - expected).length(), 0, 1e-5) << raster;
    };
    expectDirection(*panorama, {200, 100}, {0, 0, 1});
    expectDirection(*panorama, {300, 100}, {-1, 0, 0});  // right of the middle, where camera x falls
    expectDirection(*panorama, {100, 100}, {1, 0, 0});
    expectDirection(*panorama, {200, 50}, normalize(Vec3f(0, 1, 1)));
    const CameraPtr fisheye = makeFisheyeCamera(p, 180, {400, 200, 0, 0, 400, 200});
    expectDirection(*fisheye, {200, 100}, {0, 0, 1});
    expectDirection(*fisheye, {250, 100}, normalize(Vec3f(-1, 0, 1)));
    expectDirection(*fisheye, {200, 50}, normalize(Vec3f(0, 1, 1)));
    EXPECT_FALSE(fisheye->sampleRay({}, {50, 100})) << "outside the circle";
    EXPECT_FALSE(fisheye->connect({0, 0, -1}, {}));
    EXPECT_TRUE(panorama->connect({0, 0, -1}, {}));
    EXPECT_THROW(makeFisheyeCamera(p, 0, {400, 200, 0, 0, 400, 200}), Error);
    EXPECT_THROW(makeFisheyeCamera(p, 361, {400, 200, 0, 0, 400, 200}), Error);
    EXPECT_THROW(makePanoramaCamera(p, {400, 200, 0, 0, 0, 200}), Error);
}

TEST(OrthographicCamera, roundTripAndScale) {
    OrthographicParameters p;
    p.toWorld =
        Transform::lookAt({1, 2, 3}, {0.4f, -0.3f, 0.2f}, {0.1f, 1, 0.3f}) * Transform::scale({3, 3, 1});
    p.nearClip = 0.1f;
    checkRoundTrip(*makeOrthographicCamera(p, {640, 360, 0, 0, 640, 360}), 7);
    checkRoundTrip(*makeOrthographicCamera(p, {640, 360, 100, 50, 200, 120}), 8);

    // The film covers x from 1 to -1; a pixel of 400 across is 1/200 wide.
    p.toWorld = Transform();
    const CameraPtr camera = makeOrthographicCamera(p, {400, 200, 0, 0, 400, 200});
    const auto ray = camera->sampleRay({}, {0, 0});
    EXPECT_NEAR((ray->origin - Vec3f(1, 0.5f, 0.1f)).length(), 0, 1e-5);
    EXPECT_NEAR((ray->direction - Vec3f(0, 0, 1)).length(), 0, 1e-6);
    EXPECT_NEAR(ray->pdfPosition, 1 / 2.0, 1e-5) << "the film's area is 2";
    EXPECT_NEAR(camera->connect({0, 0, 5}, {})->value.x, 200 * 200, 1);
    EXPECT_FALSE(camera->connect({1.1f, 0, 5}, {}));
    EXPECT_FALSE(camera->connect({0, 0, 0.05f}, {}));
    EXPECT_NEAR(camera->pixelFootprint(100), 1 / 200.0, 1e-6);
    EXPECT_TRUE(camera->isInfinite());
}

}  // namespace
}  // namespace metrolux::core
