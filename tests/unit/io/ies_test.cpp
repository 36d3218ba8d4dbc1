/// Photometric webs (IES LM-63): what is read, where it shines, what is refused.

#include "cases_support.h"
#include "io/ies_file.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kHead = "IESNA:LM-63-2002\r\n[TEST] a lamp\r\n[MORE] TILT is said below\r\nTILT=NONE\r\n";

PhotometricWeb web(const std::string& text) {
    const TemporaryFolder folder;
    std::vector<std::string> warnings;
    return readIes(folder.write("lamp.ies", text), warnings);
}

TEST(Ies, readsAnglesAndCandelasWithTheirFactors) {
    const PhotometricWeb w = web(
        kHead + "1 1000 2.0 3 2 1 2 0 0 0\r\n0.5 1 20\r\n0 45\r\n90\r\n0, 90\r\n100 50 0\r\n80 40 10\r\n");
    EXPECT_THAT(w.vertical, ElementsAre(0, 45, 90));
    EXPECT_THAT(w.horizontal, ElementsAre(0, 90));
    EXPECT_THAT(w.values, ElementsAre(100, 50, 0, 80, 40, 10));
}

TEST(Ies, symmetriesFillTheWholeTurn) {
    const std::vector<float> vertical{0, 90};
    const PhotometricWeb quarter{vertical, {0, 45, 90}, {0, 1, 0, 2, 0, 3}};
    for (const auto& [angle, value] : {std::pair(0.0f, 1.0f),
                                       {45.0f, 2.0f},
                                       {90.0f, 3.0f},
                                       {135.0f, 2.0f},
                                       {180.0f, 1.0f},
                                       {270.0f, 3.0f},
                                       {315.0f, 2.0f},
                                       {22.5f, 1.5f}})
        EXPECT_FLOAT_EQ(quarter.at(90, angle), value) << angle;
    const PhotometricWeb half{vertical, {0, 90, 180}, {0, 1, 0, 2, 0, 3}};
    for (const auto& [angle, value] : {std::pair(180.0f, 3.0f), {270.0f, 2.0f}, {225.0f, 2.5f}})
        EXPECT_FLOAT_EQ(half.at(90, angle), value) << angle;
    const PhotometricWeb across{vertical, {90, 180, 270}, {0, 1, 0, 2, 0, 3}};
    for (const auto& [angle, value] : {std::pair(0.0f, 2.0f), {90.0f, 1.0f}, {180.0f, 2.0f}, {270.0f, 3.0f}})
        EXPECT_FLOAT_EQ(across.at(90, angle), value) << angle;
    // A whole turn may stop short of 360, where it begins again.
    const PhotometricWeb whole{vertical, {0, 90, 180, 270}, {0, 1, 0, 2, 0, 3, 0, 4}};
    EXPECT_FLOAT_EQ(whole.at(90, 315), 2.5f);
    EXPECT_FLOAT_EQ(whole.at(45, 90), 1.0f);
    EXPECT_EQ(whole.at(91, 90), 0) << "beyond the vertical angles";
}

TEST(Ies, refusals) {
    const auto refusal = [](const std::string& text) { return errorOf([&] { web(text); }); };
    const std::string ok = "1 1000 1 2 1 1 2 0 0 0\n1 1 20\n0 90\n0\n";
    EXPECT_THAT(refusal("IESNA91\n1 2 3\n"), HasSubstr("no line TILT="));
    EXPECT_THAT(refusal(kHead + ok + "10 x\n"), HasSubstr("lamp.ies:9: found \"x\", expected candelas"));
    EXPECT_THAT(refusal(kHead + ok + "10\n"), HasSubstr("the file ends"));
    EXPECT_THAT(refusal(kHead + ok + "10 -1\n"), HasSubstr("-1 candelas"));
    EXPECT_THAT(refusal(kHead + "1 1000 1 2 1 2 2 0 0 0\n"), HasSubstr("type B, which is not supported"));
    EXPECT_THAT(refusal(kHead + "1 1000 1 2 1 1 2 0 0 0\n1 1 20\n90 0\n0\n1 1\n"), HasSubstr("ascend"));
    EXPECT_THAT(refusal(kHead + "1 1000 1 99999999 1 1 2 0 0 0\n"), HasSubstr("from 1 to 4096"));
}

/// A lamp over a quad: the reflected radiance in the middle is albedo / pi * intensity / distance^2.
TEST(Ies, lightsAsItsIntensitySays) {
    const TemporaryFolder folder;
    folder.write("lamp.ies", kHead + "1 1000 1 3 1 1 2 0 0 0\n1 1 20\n0 10 90\n0\n40 40 0\n");
    const auto image = render(folder.write(
        "scene.xml", scene(R"(<integrator type="path"><integer name="max_depth" value="2"/></integrator>
<sensor type="perspective"><float name="fov" value="1"/><transform name="to_world">
<lookat origin="0,0,3" target="0,0,0" up="0,1,0"/></transform><film type="hdrfilm">
<integer name="width" value="16"/><integer name="height" value="12"/><rfilter type="box"/></film></sensor>
<emitter type="goniometric"><string name="filename" value="lamp.ies"/>
<rgb name="intensity" value="1,0.5,0.25"/><transform name="to_world"><lookat origin="0,0,2" target="0,0,0" up="0,1,0"/>
</transform></emitter>)" + quad(kHalf))));
    const float expected = 0.5f / kPi * 40 / 4;
    expectColor(meanOf(image), {expected, expected / 2, expected / 4});
}

}  // namespace
}  // namespace metrolux::core::test
