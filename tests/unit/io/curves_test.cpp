/// Curves as tubes: their area and what they hide, against closed forms.

#include "cases_support.h"
#include "io/curve_mesh.h"
#include "pbrt_support.h"

#include <gmock/gmock.h>

#include <numbers>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;

constexpr double kTau = 2 * std::numbers::pi;

SceneParts curves(const std::string& type, const std::string& text, const std::string& more = "") {
    const TemporaryFolder folder;
    folder.write("curves.txt", text);
    return loadScene(folder.write("scene.xml", underSky("<shape type=\"" + type +
                                                        R"("><string name="filename" value="curves.txt"/>)" +
                                                        more + "</shape>")),
                     {});
}

TEST(Curves, StraightTubesHaveTheAreaOfTheirCylinder) {
    // A uniform B-spline goes from its second control point to the last but one.
    const std::string line = "0 0 0 0.1\n1 0 0 0.1\n2 0 0 0.1\n3 0 0 0.1\n4 0 0 0.1\n";
    EXPECT_NEAR(curves("bsplinecurve", line).shapes[0]->area(), kTau * 0.1 * 2, 1e-4);
    EXPECT_NEAR(curves("linearcurve", line).shapes[0]->area(), kTau * 0.1 * 4, 1e-4);
    EXPECT_NEAR(curves("linearcurve", line + "\n0 2 0 0.2\n0 3 0 0.2\n").shapes[0]->area(),
                kTau * (0.1 * 4 + 0.2), 1e-4);
    EXPECT_NEAR(curves("linearcurve", line, R"(<transform name="to_world"><scale value="3"/></transform>)")
                    .shapes[0]
                    ->area(),
                kTau * 0.1 * 4 * 9, 1e-3);
}

TEST(Curves, ConesTaper) {
    // Lateral area of a frustum: pi (r0 + r1) l.
    EXPECT_NEAR(curves("linearcurve", "0 0 0 0.3\n0 0 1 0.1\n").shapes[0]->area(),
                kTau / 2 * 0.4 * std::sqrt(1 + 0.04), 2e-3);
}

TEST(Curves, ARightAngleIsMitred) {
    // The outer side of the joint is longer by r, the inner shorter: the area is that of both cylinders.
    EXPECT_NEAR(curves("linearcurve", "0 0 0 0.1\n1 0 0 0.1\n1 1 0 0.1\n").shapes[0]->area(), kTau * 0.1 * 2,
                2e-3);
    // The corner is closed: its outermost point is that of the mitre.
    Vec3f lower, upper;
    curves("linearcurve", "0 0 0 0.1\n1 0 0 0.1\n1 1 0 0.1\n").shapes[0]->bounds(lower, upper);
    EXPECT_NEAR(upper.x, 1.1f, 0.005f);
    EXPECT_NEAR(lower.y, -0.1f, 0.005f);
}

TEST(Curves, ARingHasTheAreaOfItsTorus) {
    // Control points on a circle of radius R / (2 + cos a) * 3: the spline's own radius is near R.
    std::string text;
    const int n = 24;
    const double a = kTau / n, radius = 3 / (2 + std::cos(a));
    for (int i = 0; i < n + 3; ++i)
        text += fmt::format("{} {} 0 0.05\n", radius * std::cos(i * a), radius * std::sin(i * a));
    EXPECT_NEAR(curves("bsplinecurve", text).shapes[0]->area(), kTau * kTau * 0.05,
                0.005 * kTau * kTau * 0.05);
}

TEST(Curves, ATubeHidesItsDiameter) {
    // Black before a white sky: of an orthographic view of width 2 a tube of radius 0.25 hides a quarter.
    const TemporaryFolder folder;
    folder.write("curves.txt", "0 -2 0 0.25\n0 -1 0 0.25\n0 0 0 0.25\n0 1 0 0.25\n0 2 0 0.25\n");
    for (const char* type : {"bsplinecurve", "linearcurve"}) {
        double hidden = 0;
        constexpr int kTurns = 6;
        for (int i = 0; i < kTurns; ++i) {
            const auto file = folder.write(
                "scene.xml", scene(fmt::format(R"(<sensor type="orthographic"><transform name="to_world">
<scale x="1" y="1"/><lookat origin="0,0,3" target="0,0,0" up="0,1,0"/></transform><film type="hdrfilm"><integer name="width" value="16"/>
<integer name="height" value="12"/><rfilter type="box"/></film></sensor><emitter type="constant"/>
<shape type="{}"><string name="filename" value="curves.txt"/><transform name="to_world"><rotate y="1" angle="{}"/></transform>
<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf></shape>)",
                                               type, 5 * i)));
            hidden += 1 - double(meanOf(RenderableScene(file, {}).render("path", 64, 1)).y);
        }
        EXPECT_NEAR(hidden / kTurns, 0.25, 0.003) << type;
    }
}

TEST(Curves, NormalsAreThoseOfARoundTube) {
    const SceneParts parts = curves("linearcurve", "0 0 0 0.2\n0 0 1 0.2\n");
    const auto& mesh = static_cast<const TriangleMesh&>(*parts.shapes[0]);
    for (size_t i = 0; i < mesh.positions.size(); ++i)
        EXPECT_GT(dot(mesh.normals[i], normalize(Vec3f(mesh.positions[i].x, mesh.positions[i].y, 0))),
                  0.999f);
    // Outside is where the faces look.
    SurfaceInteraction si;
    mesh.interaction(0, {0.3f, 0.3f}, si);
    EXPECT_GT(dot(si.ng, Vec3f(si.p.x, si.p.y, 0)), 0);
}

TEST(Curves, PbrtHasThemToo) {
    const auto area = [](const std::string& parameters) {
        return double(loadedPbrt(pbrtScene("LightSource \"infinite\"\nShape \"curve\" " + parameters))
                          .shapes.at(0)
                          ->area());
    };
    EXPECT_NEAR(area("\"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" 0.2"), kTau * 0.1 * 3, 1e-3);
    EXPECT_NEAR(area("\"string type\" \"cylinder\" \"string basis\" \"bspline\" \"point3 P\" [0 0 0 1 0 0 2 "
                     "0 0 3 0 0] \"float width\" 0.2"),
                kTau * 0.1, 1e-3);
    EXPECT_NEAR(area("\"integer degree\" 2 \"point3 P\" [0 0 0 1 0 0 2 0 0] \"float width0\" 0.2 \"float "
                     "width1\" 0.4"),
                kTau * 0.15 * 2, 0.01);
    EXPECT_THAT(errorOf([&] { area("\"point3 P\" [0 0 0 1 0 0 2 0 0]"); }),
                HasSubstr("found 3 control points, expected 4"));
}

TEST(Curves, ErrorsNameTheLine) {
    const std::pair<const char*, const char*> cases[] = {
        {"0 0 0 1\n0 0 1\n", "curves.txt:2: found 3 numbers"},
        {"0 0 0 1\nx\n", "curves.txt:2: expected"},
        {"0 0 0 1 2\n", "curves.txt:1: expected"},
        {"0 0 0 -1\n", "curves.txt:1: found"},
        {"0 0 0 1\n\n0 0 0 1\n0 0 1 1\n", "found a curve of 1 control points"},
        {"", "has no faces"}};
    for (const auto& [text, expected] : cases)
        EXPECT_THAT(errorOf([&] { curves("linearcurve", text); }), HasSubstr(expected)) << text;
    EXPECT_THAT(errorOf([&] { curves("bsplinecurve", "0 0 0 1\n0 0 1 1\n0 0 2 1\n"); }),
                HasSubstr("expected 4 at least"));
    // Points that coincide make no numbers that are none.
    EXPECT_TRUE(std::isfinite(
        curves("bsplinecurve", "0 0 0 1\n0 0 0 1\n0 0 0 1\n0 0 1 1\n0 0 1 1\n0 0 1 1\n").shapes[0]->area()));
    EXPECT_TRUE(std::isfinite(curves("linearcurve", "0 0 0 1\n0 0 1 1\n0 0 0 1\n").shapes[0]->area()));
}

/// "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" by gzip.
TEST(Gzip, MeshFilesMayBeCompressed) {
    const unsigned char bytes[] = {0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0xff,
                                   0x2b, 0x53, 0x30, 0x00, 0x41, 0xae, 0x32, 0x05, 0x43, 0x28,
                                   0x6d, 0x00, 0x62, 0x71, 0xa5, 0x01, 0x49, 0x23, 0x05, 0x63,
                                   0x2e, 0x00, 0x43, 0xf9, 0x6e, 0x2a, 0x20, 0x00, 0x00, 0x00};
    const std::string text(reinterpret_cast<const char*>(bytes), sizeof bytes);
    const TemporaryFolder folder;
    EXPECT_EQ(readObj(folder.write("mesh.obj", text), {})->positions.size(), 3u);
    EXPECT_EQ(readMeshFile(folder.write("mesh.obj", text + text), {}).size(),
              2 * readMeshFile(folder.write("one.obj", text), {}).size());
    for (size_t length = 2; length < text.size(); length += 3)
        EXPECT_THAT(errorOf([&] { readObj(folder.write("mesh.obj", text.substr(0, length)), {}); }),
                    HasSubstr("damaged"));
}

}  // namespace
}  // namespace metrolux::core::test
