/// A wall of 2 cm through a room: merging takes no light from one side to the other. Error rates:
/// rendering.h.

#include "rendering.h"

namespace metrolux::core {
namespace {

using namespace test;

std::vector<std::string> mergingIntegrators() {
    std::vector<std::string> names;
    for (const IntegratorDescription& integrator : integratorList())
        if (ParameterSet(integrator.parameters).find("radius")) names.push_back(integrator.name);
    return names;
}

class ThinWall : public ::testing::TestWithParam<std::string> {
  protected:
    /// A room of four units, divided by two sheets; a lamp on the right. The camera is on the left.
    ThinWall() {
        b_.add(makeCube(Transform::scale({2, 2, 2}), true), diffuse(0.7f));
        const auto sheet = [&](float x, float nx) {
            b_.add(rectangle({x, 0, 0}, {nx, 0, 0}, 2, 2), diffuse(0.7f));
        };
        sheet(0, -1);
        sheet(0.02f, 1);
        lamp(1.2f, 0.2f, 20);
        b_.camera({-1, 0, 1.8f}, {-0.6f, -0.5f, -2}, 80, 32, 24);
        b_.limits().maxDepth = 6;
    }
    void lamp(float x, float radius, float radiance) {
        b_.emit(b_.add(makeSphere(Transform(), {x, 1.3f, 0}, radius, false), diffuse(0)), Rgb(radiance));
    }
    SceneBuilder b_;
};

TEST_P(ThinWall, BehindItThereIsNoLight) {
    RenderSetup setup;
    setup.integrator = GetParam();
    setup.passes = 8;
    setup.radius = 0.1;
    for (const float v : renderImage(*b_.build(), setup, 1)) ASSERT_EQ(v, 0);
}

TEST_P(ThinWall, BeforeItNoLightIsLost) {
    // What leaked from the other side no longer makes up for the disk that the wall cuts off.
    lamp(-1.2f, 0.2f, 20);
    const std::shared_ptr<Scene> scene = b_.build();
    RenderSetup setup;
    setup.columns = setup.rows = 1;
    setup.integrator = "path";
    setup.passes = 64;
    const BlockStatistics expected = renderSeeds(*scene, setup);
    setup.integrator = GetParam();
    setup.passes = 16;
    expectSame(renderSeeds(*scene, setup), expected, 0.1, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Integrators, ThinWall, ::testing::ValuesIn(mergingIntegrators()),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace metrolux::core
