/// Scenes far from the origin are built around an origin of their own; the coordinates of the file hold
/// everywhere else.

#include "cases_support.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

SceneParts loaded(const TemporaryFolder& folder, const std::string& body) {
    LoadOptions options;
    options.fragment = true;
    return loadScene(folder.write("scene.xml", scene(body)), options);
}

std::string at(const char* transform) {
    return fmt::format("<transform name=\"to_world\">{}</transform>", transform);
}

/// Bounds in the coordinates of the file.
void expectBounds(const SceneParts& parts, size_t shape, const Vec3d& lower, const Vec3d& upper,
                  double tolerance) {
    Vec3f low, high;
    parts.shapes.at(shape)->bounds(low, high);
    EXPECT_LE((Vec3d(low) + parts.origin - lower).length(), tolerance);
    EXPECT_LE((Vec3d(high) + parts.origin - upper).length(), tolerance);
}

const std::string kFarObj =
    "v 1000000.123 0.25 -2000000.125\nv 1000001.123 0.25 -2000000.125\nv 1000001.123 1.25 -2000000.125\n"
    "f 1 2 3\n";

TEST(FarFromOrigin, keepsTheDigitsOfTransformsAndPoints) {
    const TemporaryFolder folder;
    const SceneParts parts = loaded(
        folder, R"(<sensor type="perspective">)" +
                    at(R"(<lookat origin="1000000.3,5,0" target="1000000.3,0,0" up="0,0,1"/>)") +
                    R"(</sensor><shape type="rectangle">)" + at(R"(<translate x="1000000.1"/>)") +
                    R"(</shape><shape type="sphere"><point name="center" x="1000000.7" y="0" z="0"/></shape>
<shape type="cylinder"><point name="p0" x="1000000.2" y="0" z="0"/><point name="p1" x="1000000.2" y="0" z="1"/></shape>
<emitter type="point"><point name="position" x="1000000.4" y="0" z="3"/></emitter>)");
    EXPECT_NEAR(parts.origin.x, 1e6, 4);
    EXPECT_EQ(parts.origin.y, 0);
    expectBounds(parts, 0, {999999.1, -1, 0}, {1000001.1, 1, 0}, 1e-5);
    expectBounds(parts, 1, {999999.7, -1, -1}, {1000001.7, 1, 1}, 1e-4);
    expectBounds(parts, 2, {999999.2, -1, 0}, {1000001.2, 1, 1}, 1e-4);
    EXPECT_NEAR(double(parts.camera->position().x) + parts.origin.x, 1000000.3, 1e-5);
    EXPECT_NEAR(double(parts.lights.at(0)->bounds()->lower.x) + parts.origin.x, 1000000.4, 1e-5);
    EXPECT_THAT(parts.warnings, IsEmpty());
}

TEST(FarFromOrigin, keepsTheDigitsOfMeshFiles) {
    const TemporaryFolder folder;
    folder.write("far.obj", kFarObj);
    folder.write("far.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty "
                 "double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                 "1000000.123 0.25 -2000000.125\n1000001.123 0.25 -2000000.125\n"
                 "1000001.123 1.25 -2000000.125\n3 0 1 2\n");
    for (const char* type : {"obj", "ply"}) {
        const SceneParts parts =
            loaded(folder, fmt::format(R"(<shape type="{0}"><string name="filename" value="far.{0}"/></shape>
<emitter type="constant"/>)",
                                       type));
        EXPECT_NE(parts.origin, Vec3d(0.0)) << type;
        expectBounds(parts, 0, {1000000.123, 0.25, -2000000.125}, {1000001.123, 1.25, -2000000.125}, 1e-6);
        EXPECT_THAT(parts.warnings, Each(Not(HasSubstr("detail is lost")))) << type;
    }
}

TEST(FarFromOrigin, warnsWhereSinglePrecisionHasLostTheDetail) {
    const TemporaryFolder folder;
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    folder.write("lost.ply", header + "4000000 0 0\n4000001.2 0 0\n4000001 1.3 0\n3 0 1 2\n");
    folder.write("fine.ply", header + "4000 0 0\n4001.2 0 0\n4001 1.3 0\n3 0 1 2\n");
    const auto ply = [&](const char* file) {
        return loaded(folder, fmt::format(R"(<shape type="ply"><string name="filename" value="{}"/></shape>
<emitter type="constant"/>)",
                                          file));
    };
    EXPECT_THAT(ply("lost.ply").warnings, Contains(HasSubstr("detail is lost")));
    EXPECT_THAT(ply("fine.ply").warnings, Each(Not(HasSubstr("detail is lost"))));
    EXPECT_NE(ply("fine.ply").origin, Vec3d(0.0));
}

TEST(FarFromOrigin, staysWhereThingsAreNear) {
    const TemporaryFolder folder;
    folder.write("far.obj", kFarObj);
    const std::string light = R"(<emitter type="constant"/>)";
    // A large scene, a ground that is larger still, a mesh that its transform brings home, nothing at all.
    EXPECT_EQ(
        loaded(folder, R"(<shape type="cube">)" + at(R"(<scale value="1e5"/>)") + "</shape>" + light).origin,
        Vec3d(0.0));
    EXPECT_EQ(loaded(folder, R"(<shape type="sphere"><point name="center" x="30" y="0" z="0"/></shape>
<shape type="cube"/><shape type="rectangle">)" +
                                 at(R"(<scale value="1e6"/><translate x="5e5"/>)") + "</shape>" + light)
                  .origin,
              Vec3d(0.0));
    EXPECT_EQ(loaded(folder, R"(<shape type="obj"><string name="filename" value="far.obj"/>)" +
                                 at(R"(<translate x="-1000000" z="2000000"/>)") + "</shape>" + light)
                  .origin,
              Vec3d(0.0));
    EXPECT_EQ(loaded(folder, light).origin, Vec3d(0.0));
}

TEST(FarFromOrigin, groupsHaveOriginsOfTheirOwn) {
    const TemporaryFolder folder;
    folder.write("far.obj", kFarObj);
    const SceneParts parts = loaded(
        folder, R"(<shape type="shapegroup" id="g"><shape type="obj"><string name="filename" value="far.obj"/>
</shape></shape><shape type="instance"><ref id="g"/>)" +
                    at(R"(<translate x="-1000000" z="2000000"/>)") + R"(</shape><shape type="cube"/>
<shape type="cube"/><emitter type="constant"/>)");
    EXPECT_EQ(parts.origin, Vec3d(0.0));
    const Instance& instance = parts.instances.at(0);
    Vec3f low, high;
    instance.group->shapes.at(0)->bounds(low, high);
    EXPECT_LT(low.length(), 10);
    EXPECT_LE((Vec3d(instance.toWorld.point(low)) - Vec3d(0.123, 0.25, -0.125)).length(), 1e-6);
}

TEST(FarFromOrigin, refusesWhatIsBeyondEmbrees) {
    const TemporaryFolder folder;
    const auto refusal = [&](const std::string& body) {
        return errorOf([&] { loaded(folder, body + "<shape type=\"cube\"/><emitter type=\"constant\"/>"); });
    };
    for (
        const char* body :
        {R"(<shape type="sphere"><point name="center" x="2e18" y="0" z="0"/></shape>)",
         R"(<shape type="rectangle"><transform name="to_world"><translate y="-3e20"/></transform></shape>)",
         R"(<shape type="cube"><transform name="to_world"><matrix value="1 0 0 1e60 0 1 0 0 0 0 1 0 0 0 0 1"/></transform></shape>)",
         R"(<emitter type="point"><point name="position" x="0" y="0" z="1e19"/></emitter>)",
         R"(<emitter type="spot"><transform name="to_world"><translate y="1e19"/></transform></emitter>)",
         R"(<sensor type="perspective"><transform name="to_world"><translate y="1e19"/></transform></sensor>)",
         R"(<shape type="shapegroup" id="g"><shape type="cube"/></shape><shape type="instance"><ref id="g"/>
<transform name="to_world"><translate y="1e19"/></transform></shape>)"})
        EXPECT_THAT(refusal(body), testing::AllOf(HasSubstr("scene.xml:2"), testing::AnyOf(HasSubstr("within 1.8e+18"), HasSubstr("not finite"))))
            << body;
}

}  // namespace
}  // namespace metrolux::core::test
