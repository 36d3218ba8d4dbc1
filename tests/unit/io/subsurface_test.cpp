/// Subsurface scattering of 0.6 as the medium that it approximates.

#include "cases_support.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

std::string ball(const std::string& content) {
    return scene(R"(<integrator type="volpath"><integer name="maxDepth" value="200"/></integrator>
<sensor type="perspective"><float name="fov" value="20"/><transform name="toWorld"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/>
</transform><film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="12"/><rfilter type="box"/></film>
</sensor><emitter type="constant"/><shape type="sphere">)" +
                     content + "</shape>",
                 "0.6.0");
}
SceneParts load(const std::string& content, bool lenient = false) {
    const TemporaryFolder folder;
    LoadOptions options;
    options.lenient = lenient;
    return loadScene(folder.write("scene.xml", ball(content)), options);
}
std::vector<float> picture(const std::string& content) {
    const TemporaryFolder folder;
    return RenderableScene(folder.write("scene.xml", ball(content)), {}).render("path", 8, 1);
}

const std::string kCoefficients =
    R"(<rgb name="sigmaS" value="2 3 4"/><rgb name="sigmaA" value="0.1 0.2 0.05"/>)";

TEST(Subsurface, IsTheMediumThatItApproximates) {
    const std::string medium =
        "<medium name=\"interior\" type=\"homogeneous\">" + kCoefficients + "</medium>";
    EXPECT_EQ(
        picture(
            "<subsurface type=\"dipole\">" + kCoefficients +
            R"(<float name="intIOR" value="1.4"/><float name="extIOR" value="1"/><integer name="irrSamples" value="16"/>
</subsurface><bsdf type="plastic"/>)"),
        picture(
            medium +
            R"(<bsdf type="dielectric"><float name="intIOR" value="1.4"/><float name="extIOR" value="1"/></bsdf>)"));
    EXPECT_EQ(
        picture("<subsurface type=\"dipole\">" + kCoefficients +
                R"(<string name="intIOR" value="water"/></subsurface>
<bsdf type="roughplastic"><float name="alpha" value="0.3"/><string name="distribution" value="ggx"/></bsdf>)"),
        picture(
            medium +
            R"(<bsdf type="roughdielectric"><string name="intIOR" value="water"/><float name="alpha" value="0.3"/>
<string name="distribution" value="ggx"/></bsdf>)"));
}

TEST(Subsurface, LosesNothingWithoutAbsorption) {
    const Rgb mean = meanOf(picture(
        R"(<subsurface type="dipole"><rgb name="sigmaS" value="1 1 1"/><rgb name="sigmaA" value="0 0 0"/>
</subsurface>)"));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean[k], 1, 0.02f);
}

TEST(Subsurface, SaysWhatItDoesAndRefusesTheRest) {
    const SceneParts parts = load(
        R"(<subsurface type="dipole"><string name="material" value="marble"/><float name="scale" value="10"/>
</subsurface>)");
    EXPECT_THAT(parts.warnings,
                Contains(AllOf(HasSubstr("<subsurface"), HasSubstr("medium that it approximates"))));
    EXPECT_EQ(parts.media.size(), 1u);
    const auto error = [](const std::string& content) { return errorOf([&] { load(content); }); };
    EXPECT_THAT(error("<subsurface type=\"singlescatter\"/>"),
                AllOf(HasSubstr("scene.xml:"), HasSubstr("\"singlescatter\" is not supported")));
    EXPECT_THAT(error("<subsurface type=\"tripole\"/>"), HasSubstr("did you mean \"dipole\""));
    EXPECT_THAT(error("<subsurface type=\"dipole\"/><subsurface type=\"dipole\"/>"),
                HasSubstr("second <subsurface>"));
    EXPECT_THAT(error("<subsurface type=\"dipole\"/><medium name=\"interior\" type=\"homogeneous\"/>"),
                HasSubstr("one of the two"));
    EXPECT_THAT(error(R"(<subsurface type="dipole"><string name="material" value="cheese"/></subsurface>)"),
                HasSubstr("\"cheese\""));
    EXPECT_THAT(error(R"(<subsurface type="dipole"><float name="intIOR" value="-1"/></subsurface>)"),
                HasSubstr("positive index"));
    EXPECT_EQ(load("<subsurface type=\"singlescatter\"/>", true).media.size(), 0u);
}

TEST(Subsurface, ShapesShareOne) {
    const TemporaryFolder folder;
    const auto file = folder.write(
        "scene.xml", underSky(R"(<subsurface type="dipole" id="s"/><shape type="sphere"><ref id="s"/></shape>
<shape type="cube"><ref id="s"/></shape>)",
                              "0.6.0"));
    EXPECT_EQ(loadScene(file, {}).media.size(), 1u);
}

}  // namespace
}  // namespace metrolux::core::test
