/// Dispersion along subpaths: a prism against Snell's law, and colors where subpaths are joined.

#include "sampling/streams.h"
#include "scattering/thin_dielectric.h"
#include "support/small_scenes.h"
#include "transport/connect.h"
#include "transport/eye_pass.h"
#include "transport/subpath.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using namespace test;

/// Takes the lobe that transmits, always.
class Straight final : public SampleStream {
  public:
    void seek(int) override {}
    float next1D() override { return kOneMinusEpsilon; }
    Vec2f next2D() override { return Vec2f(0.5f); }
    void skip(int) override {}
};

class Way final : public SubpathVisitor {
  public:
    std::vector<Vertex> vertices;
    std::optional<WalkEdge> last;
    bool surface(const Vertex& v) override {
        vertices.push_back(v);
        return true;
    }
    void escaped(const Vec3f&, const WalkEdge& edge, int) override { last = edge; }
};

constexpr double kApex = 60 * std::numbers::pi / 180;

/// Faces that meet at the apex angle in the line x = 0, z = 1; seen from -x, slightly from below, so that the
/// light goes through without being reflected totally. The camera looks along `incidence` to the first face.
std::shared_ptr<Scene> prism(const BsdfPtr& glass, double incidence) {
    SceneBuilder b;
    const auto s = static_cast<float>(std::sin(kApex / 2)), c = static_cast<float>(std::cos(kApex / 2));
    const Vec3f first(-c, 0, s), second(c, 0, s);  // outward normals
    for (const Vec3f& n : {first, second})
        b.add(rectangle(Vec3f(0, 0, 1) + Vec3f(n.x < 0 ? -s : s, 0, -c), n, 2, 2), glass);
    // A ray that comes in at this angle to the normal, from the side of the base.
    const auto si = static_cast<float>(std::sin(incidence)), ci = static_cast<float>(std::cos(incidence));
    const Vec3f along(s, 0, c);  // up the first face
    const Vec3f direction = -first * ci + along * si, target(-s, 0, 1 - c);
    b.camera(target - direction * 3.0f, target, 1, 1, 1);
    b.light(makeConstantLight({}));
    b.limits().rouletteDepth = 100;
    return b.build();
}

/// Angle by which the ray through the middle of the image leaves its way, in radians.
double deviation(const Scene& scene, const Wavelength& wavelength) {
    Straight stream;
    Strategies strategies = Strategies::path();
    strategies.wavelength = wavelength;
    Way way;
    traceEyeSubpath(scene, stream, scene.parts().limits, strategies, Vec2f(0.5f), 1, 0, way);
    EXPECT_EQ(way.vertices.size(), 2u);
    EXPECT_TRUE(way.last.has_value());
    if (way.vertices.empty() || !way.last) return 0;
    return std::acos(double(dot(-way.vertices[0].toPrevious, way.last->ray.direction)));
}

double bySnell(double n, double incidence) {
    const double inside = std::asin(std::sin(incidence) / n), second = kApex - inside;
    return incidence + std::asin(n * std::sin(second)) - kApex;
}

TEST(Prism, DeviatesFiveWavelengthsAsSnellSays) {
    // Published indices of SF11 and BK7 (SCHOTT) at the lines r, C, d, F and h.
    const double lines[] = {706.5188, 656.2725, 587.5618, 486.1327, 404.6561};
    const struct {
        const char* glass;
        std::array<double, 5> index;
        double incidence;
    } cases[] = {{"SF11", {1.77125, 1.77599, 1.78472, 1.80645, 1.84208}, 1.11},
                 {"BK7", {1.51289, 1.51432, 1.51680, 1.52238, 1.53024}, 0.86}};
    for (const auto& [glass, index, incidence] : cases) {
        const auto scene = prism(makeDielectric({RelativeIndex(*Dispersion::named(glass), 1)}), incidence);
        EXPECT_TRUE(scene->hasDispersion());
        for (size_t i = 0; i < 5; ++i) {
            const double measured = deviation(*scene, {static_cast<float>(lines[i]), Rgb(1.0f)}),
                         expected = bySnell(index[i], incidence);
            // 1e-5 of the table's last digit are 2e-5 radians here, the differences between lines 1e-3 and
            // more.
            EXPECT_NEAR(measured, expected, 5e-5) << glass << " at " << lines[i] << " nm";
            std::printf("%s %.1f nm: %.4f degrees, by Snell %.4f\n", glass, lines[i],
                        measured * 180 / std::numbers::pi, expected * 180 / std::numbers::pi);
        }
    }
}

TEST(Prism, WithoutAWavelengthHasTheIndexOfLineD) {
    const auto scene = prism(makeDielectric({RelativeIndex(*Dispersion::named("SF11"), 1)}), 1.11);
    EXPECT_NEAR(deviation(*scene, {}), bySnell(1.78472, 1.11), 5e-5);
}

/// A ball of glass over a floor, with or without dispersion.
std::shared_ptr<Scene> ball(const RelativeIndex& eta) {
    SceneBuilder b;
    b.add(rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), diffuse(0.7f));
    b.add(makeSphere(Transform(), {0, 1, 0}, 0.7f, false), makeDielectric({eta}));
    b.emit(b.add(rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), diffuse(0.3f)), Rgb(5));
    b.light(makeConstantLight({}));
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 32, 32);
    b.limits().maxDepth = 6;
    return b.build();
}

Way walk(const Scene& scene, const Strategies& n, uint64_t key, bool eye) {
    Way way;
    IndependentStream stream(key);
    if (eye)
        traceEyeSubpath(scene, stream, scene.parts().limits, n, read(stream, layout::kRaster) * 32.0f, 1, 0,
                        way);
    else
        traceLightSubpath(scene, stream, scene.parts().limits, n, way);
    return way;
}

/// Every technique shows the color once where either subpath has met dispersion, and else not at all.
TEST(Dispersion, JoinedPathsHaveTheColorOnce) {
    const auto scene = ball(RelativeIndex(*Dispersion::named("SF11"), 1));
    Strategies white = Strategies::bidirectional(1, 0.1);
    white.wavelength = {470, Rgb(1.0f)};
    Strategies colored = white;
    colored.wavelength.color = Rgb(2, 3, -0.5f);
    std::map<std::string, std::array<int, 2>> seen;
    const auto check = [&](const char* technique, bool dispersed, const Rgb& with, const Rgb& without) {
        if (isBlack(without)) return;
        const Rgb expected = dispersed ? without * colored.wavelength.color : without;
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(with[c], expected[c], 1e-6f * std::abs(expected[c])) << technique;
        ++seen[technique][dispersed];
    };
    for (uint64_t i = 0; i < 40000; ++i) {
        const Way eye = walk(*scene, white, hashKey(i, 1), true),
                  light = walk(*scene, white, hashKey(i, 2), false);
        for (const Vertex& e : eye.vertices) {
            if (e.emitter())
                check("hit", e.dispersed, hitLight(*scene, colored, e).value,
                      hitLight(*scene, white, e).value);
            if (!e.hasSmoothLobe()) continue;
            const auto nee = [&](const Strategies& n) {
                return connectToLight(*scene, n, e, 0.3f, Vec2f(0.4f)).value;
            };
            check("nee", e.dispersed, nee(colored), nee(white));
            for (const Vertex& l : light.vertices) {
                if (!l.hasSmoothLobe()) continue;
                const bool dispersed = l.dispersed || e.dispersed;
                check("connect", dispersed, connectVertices(*scene, colored, l, e).value,
                      connectVertices(*scene, white, l, e).value);
                check("merge", dispersed, mergeVertices(colored, l, e, 1).value,
                      mergeVertices(white, l, e, 1).value);
            }
        }
        if (eye.last) {
            const auto sky = [&](const Strategies& n) {
                return hitEnvironment(*scene, n, Vec3f(0.0f), *eye.last, 3).value;
            };
            check("sky", eye.last->dispersed, sky(colored), sky(white));
        }
        for (const Vertex& l : light.vertices) {
            if (!l.hasSmoothLobe()) continue;
            Vec2f raster;
            check("splat", l.dispersed, connectToCamera(*scene, colored, l, Vec2f(0.5f), raster).value,
                  connectToCamera(*scene, white, l, Vec2f(0.5f), raster).value);
        }
    }
    for (const char* technique : {"hit", "nee", "connect", "merge", "sky", "splat"})
        for (const int count : seen[technique]) EXPECT_GT(count, 10) << technique;
}

TEST(Dispersion, WithoutAnyInTheSceneNothingIsMarked) {
    const auto scene = ball(1.5f);
    EXPECT_FALSE(scene->hasDispersion());
    for (uint64_t i = 0; i < 500; ++i)
        for (const bool eye : {true, false})
            for (const Vertex& v : walk(*scene, Strategies::path(), i, eye).vertices)
                EXPECT_FALSE(v.dispersed);
}

/// In fog light passes a sheet of glass without a vertex: the way through it counts.
TEST(Dispersion, ASheetThatIsPassedMarksThePath) {
    SceneBuilder b;
    b.media() = {makeHomogeneousMedium(Rgb(1e-4f), Rgb(0.9f), makeIsotropicPhase())};
    b.add(rectangle({0, 0, 0}, {0, 0, 1}, 4, 4),
          makeThinDielectric({RelativeIndex(*Dispersion::named("SF11"), 1)}));
    b.add(rectangle({0, 0, -2}, {0, 0, 1}, 4, 4), diffuse(0.5f));
    b.camera({0, 0, 5}, {0, 0, 0}, 20, 8, 8);
    b.cameraInMedium(1);
    const auto scene = b.build();
    const Ray ray{Vec3f(0, 0, 2), Vec3f(0, 0, -1), 3};
    EXPECT_TRUE(passAlong(*scene, ray, 1, 500).dispersed);
    EXPECT_FALSE(passAlong(*scene, ray, 1).dispersed);
    EXPECT_FALSE(passAlong(*scene, {ray.origin, -ray.direction, 4}, 1, 500).dispersed);
    // The share that passes is that of the wavelength.
    EXPECT_LT(passAlong(*scene, ray, 1, 400).transmittance.x, passAlong(*scene, ray, 1, 700).transmittance.x);
    // A walk to the floor behind it.
    Strategies n = Strategies::path();
    n.wavelength = {500, Rgb(1.0f)};
    Straight stream;
    Way way;
    traceEyeSubpath(*scene, stream, scene->parts().limits, n, Vec2f(4.0f), 1, 0, way);
    ASSERT_FALSE(way.vertices.empty());
    EXPECT_FALSE(way.vertices[0].inMedium);
    EXPECT_TRUE(way.vertices[0].hasSmoothLobe());
    EXPECT_TRUE(way.vertices[0].dispersed);
}

}  // namespace
}  // namespace metrolux::core
