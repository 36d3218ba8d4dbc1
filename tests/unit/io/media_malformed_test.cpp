/// Bad media: each is refused with an Error that names file, line and element, what was found and expected.

#include "media_support.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;

std::string inCube(const std::string& medium, const std::string& more = "<bsdf type=\"null\"/>") {
    return "<shape type=\"cube\">" + more + medium + "</shape>";
}
std::string fog(const std::string& content, const std::string& type = "homogeneous") {
    return inCube("<medium name=\"interior\" type=\"" + type + "\">" + content + "</medium>");
}
std::string grid(const std::string& file) {
    return fog(R"(<volume name="sigma_t" type="gridvolume"><string name="filename" value=")" + file +
                   "\"/></volume>",
               "heterogeneous");
}

struct Bad {
    std::string name, body;
    std::vector<std::string> expected;  ///< parts of the message
    std::string version = "3.0.0";
    std::string file = {};  ///< content of a.vol
};

const std::vector<Bad> kBad = {
    {"negative_sigma",
     fog(R"(<rgb name="sigma_t" value="1, -2, 3"/>)"),
     {"<medium type=\"homogeneous\">", "\"sigma_t\"", "found -2", "zero or more"}},
    {"negative_sigma_of_a_volume",
     fog(R"(<volume name="sigma_t" type="constvolume"><float name="value" value="-1"/></volume>)",
         "heterogeneous"),
     {"<volume type=\"constvolume\">", "found -1"}},
    {"albedo_above_one",
     fog(R"(<rgb name="albedo" value="1.5, 0, 0"/>)"),
     {"\"albedo\"", "found 1.5", "albedo in [0, 1]"}},
    {"negative_scale", fog(R"(<float name="scale" value="-1"/>)"), {"\"scale\"", "found -1"}},
    {"truncated_vol", grid("a.vol"), {"a.vol"}, "3.0.0", volFile({4, 4, 4}, {1, 2, 3})},
    {"grid_of_many_cells", grid("a.vol"), {"a.vol"}, "3.0.0", volFile({10000, 10000, 10000}, {1})},
    {"six_channels",
     grid("a.vol"),
     {"a.vol", "channels"},
     "3.0.0",
     volFile({1, 1, 1}, {1, 2, 3, 4, 5, 6}, 6)},
    {"negative_cells", grid("a.vol"), {"a.vol"}, "3.0.0", volFile({-1, 1, 1}, {1})},
    {"no_vol", grid("a.vol"), {"a.vol"}, "3.0.0", "not a grid"},
    {"missing_volume_file", grid("none.vol"), {"none.vol", "does not exist"}},
    {"box_without_a_volume",
     fog(R"(<volume name="sigma_t" type="gridvolume"><string name="filename" value="a.vol"/>
        <boolean name="use_grid_bbox" value="true"/></volume>)",
         "heterogeneous"),
     {"<volume type=\"gridvolume\">", "expected one with a volume"},
     "3.0.0",
     volFile({2, 2, 2}, std::vector<float>(8, 1.0f), 1, {0, 0, 0, 1, 0, 1})},
    {"negative_value_in_a_grid",
     grid("a.vol"),
     {"<volume type=\"gridvolume\">"},
     "3.0.0",
     volFile({1, 1, 1}, {-1})},
    {"albedo_grid_above_one",
     fog(R"(<volume name="albedo" type="gridvolume"><string name="filename" value="a.vol"/></volume>)",
         "heterogeneous"),
     {"albedo"},
     "3.0.0",
     volFile({1, 1, 1}, {2})},
    {"flattened_volume",
     fog(R"(<volume name="sigma_t" type="constvolume"><transform name="to_world"><scale x="0"/></transform>
        </volume>)",
         "heterogeneous"),
     {"<volume type=\"constvolume\">", "singular"}},
    {"unknown_wrap_mode",
     fog(R"(<volume name="sigma_t" type="gridvolume"><string name="filename" value="a.vol"/>
        <string name="wrap_mode" value="zero"/></volume>)",
         "heterogeneous"),
     {"\"wrap_mode\"", "found \"zero\"", "clamp, repeat, mirror"},
     "3.0.0",
     volFile({1, 1, 1}, {1})},
    {"unknown_id",
     inCube("<ref name=\"interior\" id=\"fgo\"/>") + "<medium type=\"homogeneous\" id=\"fog\"/>",
     {"<ref id=\"fgo\">", "did you mean \"fog\""}},
    {"g_out_of_range",
     fog(R"(<phase type="hg"><float name="g" value="1"/></phase>)"),
     {"<phase type=\"hg\">", "g is 1", "(-1, 1)"}},
    {"weight_out_of_range",
     fog(R"(<phase type="blendphase"><float name="weight" value="2"/><phase type="hg"/><phase type="rayleigh"/>
        </phase>)"),
     {"\"weight\"", "found 2", "[0, 1]"}},
    {"one_part_of_a_blend",
     fog(R"(<phase type="blendphase"><phase type="hg"/></phase>)"),
     {"found 1 nested <phase>", "expected 2"}},
    {"table_of_letters",
     fog(R"(<phase type="tabphase"><string name="values" value="1, a"/></phase>)"),
     {"\"values\"", "found \"a\""}},
    {"table_of_one_value",
     fog(R"(<phase type="tabphase"><string name="values" value="1"/></phase>)"),
     {"<phase type=\"tabphase\">"}},
    {"both_pairs",
     fog(R"(<float name="sigma_t" value="1"/><float name="sigma_s" value="1"/>)"),
     {"found \"sigma_s\" as well as \"sigma_t\""}},
    {"both_pairs_of_06",
     fog(R"(<spectrum name="sigmaT" value="1"/><spectrum name="sigmaS" value="1"/>)"),
     {"<medium type=\"homogeneous\">", "one of the pairs"},
     "0.6.0"},
    {"preset_and_coefficients",
     fog(R"(<string name="material" value="Skin1"/><spectrum name="sigmaS" value="1"/>)"),
     {"\"material\" as well as"},
     "0.6.0"},
    {"two_interiors",
     inCube(
         "<medium name=\"interior\" type=\"homogeneous\"/><medium name=\"interior\" type=\"homogeneous\"/>"),
     {"\"interior\" a second time"}},
    {"medium_of_no_side",
     inCube("<medium type=\"homogeneous\"/>"),
     {"without a name", "interior or exterior"}},
    {"emitting_null_boundary",
     inCube("<medium name=\"interior\" type=\"homogeneous\"/>",
            "<bsdf type=\"null\"/><emitter type=\"area\"/>"),
     {"<shape type=\"cube\">", "emits and has the BSDF null"}},
    {"two_phase_functions",
     fog("<phase type=\"hg\"/><phase type=\"isotropic\"/>"),
     {"found 2 phase functions"}},
    {"emission",
     fog("<float name=\"emission\" value=\"1\"/>", "heterogeneous"),
     {"emissive media are not supported"}},
    {"unknown_property",
     fog("<float name=\"sigmat\" value=\"1\"/>"),
     {"\"sigmat\"", "did you mean \"sigma_t\""}},
    {"grid_in_a_homogeneous",
     fog(R"(<volume name="sigma_t" type="gridvolume"><string name="filename" value="a.vol"/></volume>)"),
     {"\"sigma_t\"", "varies"},
     "3.0.0",
     volFile({2, 1, 1}, {1, 2})},
    {"microflakes",
     fog("<phase type=\"sggx\"/>"),
     {"<phase type=\"sggx\">", "is not supported", "orientation"}},
    {"subsurface",
     "<shape type=\"cube\"><subsurface type=\"dipole\"/></shape>",
     {"<subsurface", "expected a medium"}},
    {"two_media_of_a_light",
     R"(<emitter type="point"><medium name="a" type="homogeneous"/><medium name="b" type="homogeneous"/></emitter>)",
     {"<emitter type=\"point\">", "found 2 media"}},
    {"bsdf_as_albedo",
     fog("<bsdf name=\"albedo\" type=\"diffuse\"/>"),
     {"\"albedo\"", "expected a <volume>"}},
    {"phases_of_phases",
     [] {
         std::string body;
         for (int i = 0; i < 40; ++i)
             body += fmt::format(
                 "<phase type=\"blendphase\" id=\"p{0}\"><ref id=\"p{1}\"/><ref id=\"p{1}\"/></phase>\n", i,
                 i + 1);
         return body + "<phase type=\"hg\" id=\"p40\"/>";
     }(),
     {"<phase type=\"blendphase\"", "4096 parts"}},
};

class BadMedium : public testing::TestWithParam<Bad> {};

TEST_P(BadMedium, IsRefusedWithItsPlace) {
    const Bad& bad = GetParam();
    const TemporaryFolder folder;
    if (!bad.file.empty()) folder.write("a.vol", bad.file);
    const auto file = folder.write("scene.xml", withMedia(bad.body, bad.version));
    LoadOptions options;
    options.memoryBytes = uint64_t{1} << 30;
    const std::string message = errorOf([&] { loadScene(file, options); });
    EXPECT_THAT(message, HasSubstr("scene.xml:"));
    for (const std::string& part : bad.expected) EXPECT_THAT(message, HasSubstr(part));
    EXPECT_LT(message.size(), 1000u);
}

INSTANTIATE_TEST_SUITE_P(Media, BadMedium, testing::ValuesIn(kBad),
                         [](const auto& bad) { return bad.param.name; });

}  // namespace
}  // namespace metrolux::core::test
