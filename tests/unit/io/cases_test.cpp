/// What other people's scenes hold and was once refused or read wrong: materials, textures, files. The value
/// is the reflectance that the image shows.

#include "cases_support.h"
#include "image/image_io.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

class Cases : public testing::Test {
  protected:
    Rgb color(const std::string& text, const LoadOptions& options = {}) {
        return meanOf(render(folder_.write("scene.xml", text), options));
    }
    SceneParts load(const std::string& text, const LoadOptions& options = {}) {
        return loadScene(folder_.write("scene.xml", text), options);
    }
    std::string error(const std::string& text, const LoadOptions& options = {}) {
        return errorOf([&] { load(text, options); });
    }
    /// 32 x 32 pixels of one color, in codes from 0 to 1.
    void writeImage(const std::string& name, const std::array<float, 3>& color) {
        ImageData image;
        image.width = image.height = 32;
        image.channels = 3;
        for (int i = 0; i < 32 * 32; ++i) image.pixels.insert(image.pixels.end(), color.begin(), color.end());
        writePngRaw(folder_.path() / name, image);
    }
    void writeGray() { writeImage("gray.png", {128 / 255.f, 128 / 255.f, 128 / 255.f}); }

    TemporaryFolder folder_;
};

constexpr float kGray = 0.2158605f;  // sRGB 128

std::string bitmap(const std::string& properties, const std::string& file = "gray.png") {
    return fmt::format(
        R"(<texture name="reflectance" type="bitmap"><string name="filename" value="{}"/>{}</texture>)", file,
        properties);
}
std::string text(const std::string& name, const std::string& value) {
    return fmt::format(R"(<string name="{}" value="{}"/>)", name, value);
}

TEST_F(Cases, OldFilmsBecomeOurs) {
    const std::string film = text("fileFormat", "png") + text("pixelFormat", "rgb") +
                             R"(<float name="gamma" value="2.2"/><boolean name="banner" value="false"/>
                             <rfilter type="tent"/>)";
    for (const char* type : {"ldrfilm", "mfilm", "tiledhdrfilm"}) {
        const std::string scene = underSky(quad(kHalf), "0.6.0", 2, film, type);
        expectGray(color(scene), 0.5f);
        const auto warnings = load(scene).warnings;
        EXPECT_THAT(warnings, Contains(HasSubstr("file_format \"png\" has no effect"))) << type;
        EXPECT_THAT(warnings, Contains(AllOf(HasSubstr("gamma"), HasSubstr("banner")))) << type;
    }
    EXPECT_THAT(error(underSky(quad(kHalf), "3.0.0", 2, text("file_format", "png"))),
                HasSubstr("file_format"));
    EXPECT_THAT(error(underSky(quad(kHalf), "3.0.0", 2, "", "ldrfilm")), HasSubstr("unknown film type"));
}

TEST_F(Cases, ThreeNumbersOfASpectrumAreTheChannelsIn06) {
    const auto with = [](const std::string& version, const std::string& value) {
        return underSky(quad(diffuse("<spectrum name=\"reflectance\" value=\"" + value + "\"/>")), version);
    };
    expectColor(color(with("0.6.0", "0.1, 0.2, 0.3")), {0.1f, 0.2f, 0.3f});
    expectColor(color(with("0.5.0", "0.1 0.2 0.3")), {0.1f, 0.2f, 0.3f});
    for (const char* version : {"2.1.0", "3.0.0"})
        EXPECT_THAT(error(with(version, "0.1, 0.2, 0.3")), HasSubstr("expected one number"));
    for (const char* wrong : {"0.1, 0.2", "0.1, 0.2, 0.3, 0.4", "0.1, x, 0.3"})
        EXPECT_THAT(error(with("0.6.0", wrong)), HasSubstr("scene.xml:")) << wrong;
}

TEST_F(Cases, SpectraAndTexturesAreOneKindOfPlugin) {
    writeGray();
    for (const char* version : {"2.1.0", "3.0.0"}) {
        const std::string image =
            R"(<spectrum name="reflectance" type="bitmap">)" + text("filename", "gray.png") + "</spectrum>";
        expectGray(color(underSky(quad(diffuse(image)), version)), kGray);
        const std::string board =
            R"(<spectrum name="reflectance" type="checkerboard"><rgb name="color0" value="0.3"/>
            <rgb name="color1" value="0.3"/></spectrum>)";
        expectGray(color(underSky(quad(diffuse(board)), version)), 0.3f);
        const std::string uniform =
            R"(<texture name="reflectance" type="uniform"><float name="value" value="0.3"/></texture>)";
        expectGray(color(underSky(quad(diffuse(uniform)), version)), 0.3f);
        const std::string shared =
            R"(<spectrum type="srgb" id="c"><rgb name="color" value="0.1 0.2 0.3"/></spectrum>)";
        expectColor(color(underSky(shared + quad(diffuse(R"(<ref name="reflectance" id="c"/>)")), version)),
                    {0.1f, 0.2f, 0.3f});
    }
}

const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\n{}element face 2\nproperty list uchar int vertex_indices\n{}end_header\n"
    "-1 -1 0{}\n1 -1 0{}\n1 1 0{}\n-1 1 0{}\n3 0 1 2{}\n3 0 2 3{}\n";

std::string attribute(const std::string& name) {
    return diffuse(
        fmt::format(R"(<texture name="reflectance" type="mesh_attribute">{}</texture>)", text("name", name)));
}
std::string mesh(const std::string& type, const std::string& file, const std::string& more) {
    return fmt::format(R"(<shape type="{}">{}{}</shape>)", type, text("filename", file), more);
}

TEST_F(Cases, MissingMeshAttributesAreErrors) {
    folder_.write("plain.ply", fmt::format(fmt::runtime(kPly), "", "", "", "", "", "", "", ""));
    folder_.write("q.obj", kQuadFile);
    EXPECT_THAT(error(underSky(mesh("ply", "plain.ply", attribute("vertex_color")))),
                AllOf(HasSubstr("scene.xml:"), HasSubstr("\"vertex_color\""), HasSubstr("it has none")));
    EXPECT_THAT(error(underSky(mesh("obj", "q.obj", attribute("face_color")))), HasSubstr("\"face_color\""));
    EXPECT_THAT(error(underSky(quad(attribute("vertex_color")))), HasSubstr("\"vertex_color\""));
    EXPECT_THAT(error(underSky("<shape type=\"sphere\">" + attribute("vertex_color") + "</shape>")),
                HasSubstr("\"vertex_color\""));
    const std::string nested = "<bsdf type=\"twosided\">" + attribute("vertex_tint") + "</bsdf>";
    const std::string group = R"(<shape type="shapegroup" id="g">)" + mesh("ply", "plain.ply", nested) +
                              R"(</shape><shape type="instance"><ref id="g"/></shape>)";
    EXPECT_THAT(error(underSky(group)), HasSubstr("\"vertex_tint\""));
    const std::string light = R"(<emitter type="area"><texture name="radiance" type="mesh_attribute">)" +
                              text("name", "face_light") + "</texture></emitter>";
    EXPECT_THAT(error(underSky(mesh("ply", "plain.ply", light))), HasSubstr("\"face_light\""));

    const std::string color = "property float r\nproperty float g\nproperty float b\n";
    folder_.write("colored.ply",
                  fmt::format(fmt::runtime(kPly), color, "", " 1 1 1", " 1 1 1", " 1 1 1", " 1 1 1", "", ""));
    EXPECT_THAT(error(underSky(mesh("ply", "colored.ply", attribute("vertex_colour")))),
                HasSubstr("it has: vertex_color"));
    LoadOptions lenient;
    lenient.lenient = true;
    EXPECT_THAT(load(underSky(mesh("ply", "plain.ply", attribute("vertex_color"))), lenient).warnings,
                Contains(HasSubstr("vertex_color")));
}

TEST_F(Cases, PlyAttributesHaveMitsubasNames) {
    const auto expect = [&](const std::string& suffixes, const std::string& name,
                            const std::string& element) {
        std::string properties;
        for (const char suffix : suffixes) properties += fmt::format("property float albedo_{}\n", suffix);
        const std::string values = suffixes.size() == 1   ? " 0.25"
                                   : suffixes.size() == 4 ? " 0.5 0.25 0.125 1"
                                                          : " 0.5 0.25 0.125";
        const bool ofVertices = element == "vertex";
        const std::string v = ofVertices ? values : "", f = ofVertices ? "" : values;
        folder_.write("a.ply", fmt::format(fmt::runtime(kPly), ofVertices ? properties : "",
                                           ofVertices ? "" : properties, v, v, v, v, f, f));
        SCOPED_TRACE(name);
        const Rgb expected = suffixes.size() == 1 ? Rgb(0.25f) : Rgb(0.5f, 0.25f, 0.125f);
        expectColor(color(underSky(mesh("ply", "a.ply", attribute(name)))), expected);
    };
    for (const char* element : {"vertex", "face"}) {
        expect("rgb", fmt::format("{}_albedo_color", element), element);
        expect("rgba", fmt::format("{}_albedo_color", element), element);
        expect("xyz", fmt::format("{}_albedo", element), element);
        expect("012", fmt::format("{}_albedo", element), element);
        expect("123", fmt::format("{}_albedo", element), element);
        expect("x", fmt::format("{}_albedo", element), element);
    }
}

TEST_F(Cases, TheWorkingFolderIsSearchedLast) {
    const auto before = std::filesystem::current_path();
    std::filesystem::create_directories(folder_.path() / "data");
    std::filesystem::create_directories(folder_.path() / "scenes");
    folder_.write("data/q.obj", kQuadFile);
    const auto file = folder_.write("scenes/scene.xml", underSky(mesh("obj", "data/q.obj", kHalf)));
    std::filesystem::current_path(folder_.path());
    expectGray(meanOf(render(file)), 0.5f);
    // The scene's own folder goes first.
    std::filesystem::create_directories(folder_.path() / "scenes/data");
    folder_.write("scenes/data/q.obj", "v 5 5 5\nv 6 5 5\nv 5 6 5\nf 1 2 3\n");
    expectGray(meanOf(render(file)), 1);
    std::filesystem::current_path(before);
}

TEST_F(Cases, WrapModesOf06) {
    // Texture coordinates of the quad run from 0 to 1; the map moves the image out of sight.
    writeGray();
    const auto at = [&](const std::string& modes, float uoffset, float voffset) {
        const std::string shift = fmt::format(
            R"(<float name="uoffset" value="{}"/><float name="voffset" value="{}"/>)", uoffset, voffset);
        return color(underSky(quad(diffuse(bitmap(modes + shift))), "0.6.0"));
    };
    for (const char* mode : {"repeat", "mirror", "clamp", "zero", "one"})
        expectGray(at(text("wrapMode", mode), 0, 0), kGray);
    expectGray(at(text("wrapMode", "zero"), 3, 0), 0);
    expectGray(at(text("wrapMode", "one"), 0, 3), 1);
    expectGray(at(text("wrapMode", "repeat"), 3, 3), kGray);
    expectGray(at(text("wrapModeU", "clamp") + text("wrapModeV", "clamp"), 3, 3), kGray);
    expectGray(at(text("wrapModeU", "zero") + text("wrapModeV", "one"), 3, 0), 0);
    expectGray(at(text("wrapModeU", "zero") + text("wrapModeV", "one"), 0, 3), 1);
    expectGray(at(text("wrapMode", "one") + text("wrapModeV", "zero"), 0, 3), 0);
    EXPECT_THAT(error(underSky(quad(diffuse(bitmap(text("wrapMode", "zer")))), "0.6.0")),
                HasSubstr("zero, one"));
    EXPECT_THAT(error(underSky(quad(diffuse(bitmap(text("wrap_mode", "zero")))))), HasSubstr("wrap_mode"));
}

TEST_F(Cases, ChannelsOf06) {
    writeImage("rgb.png", {0.2f, 0.4f, 0.6f});
    const auto of = [&](const std::string& channel) {
        return underSky(
            quad(diffuse(bitmap(text("channel", channel) + R"(<float name="gamma" value="1"/>)", "rgb.png"))),
            "0.6.0");
    };
    expectGray(color(of("r")), 0.2f);
    expectGray(color(of("g")), 0.4f);
    expectGray(color(of("b")), 0.6f);
    EXPECT_THAT(error(of("a")), AllOf(HasSubstr("\"a\""), HasSubstr("r, g, b")));
}

TEST_F(Cases, ParametersOf2xWithoutEffect) {
    const std::string film = R"(<boolean name="high_quality_edges" value="false"/><rfilter type="box"/>)";
    expectGray(color(underSky(quad(kHalf), "2.1.0", 2, film)), 0.5f);
    EXPECT_THAT(load(underSky(quad(kHalf), "2.1.0", 2, film)).warnings, IsEmpty());
    EXPECT_THAT(error(underSky(quad(kHalf), "3.0.0", 2, film)), HasSubstr("high_quality_edges"));
}

TEST_F(Cases, ScaledTexturesOf06) {
    const std::string white = R"(<texture type="checkerboard"><rgb name="color0" value="1"/>
        <rgb name="color1" value="1"/></texture></texture>)";
    const std::string number =
        R"(<texture name="reflectance" type="scale"><float name="scale" value="0.5"/>)";
    const std::string tint =
        R"(<texture name="reflectance" type="scale"><rgb name="scale" value="0.1 0.2 0.3"/>)";
    expectGray(color(underSky(quad(diffuse(number + white)), "0.6.0")), 0.5f);
    expectColor(color(underSky(quad(diffuse(tint + white)), "0.6.0")), {0.1f, 0.2f, 0.3f});
    EXPECT_THAT(error(underSky(quad(diffuse(number + white)))), HasSubstr("unknown texture type"));
    EXPECT_THAT(error(underSky(quad(diffuse(number + "</texture>")), "0.6.0")), HasSubstr("found 0 nested"));
    const std::string bump = R"(<bsdf type="bumpmap"><texture type="scale"><float name="scale" value="0.1"/>
        <texture type="checkerboard"/></texture>)" +
                             kHalf + "</bsdf>";
    expectGray(color(underSky(quad(bump), "0.6.0")), 0.5f);
}

TEST_F(Cases, VertexColorsOf06) {
    const std::string properties = "property float r\nproperty float g\nproperty float b\n";
    const std::string v = " 0.5 0.25 0.125";
    folder_.write("c.ply", fmt::format(fmt::runtime(kPly), properties, "", v, v, v, v, "", ""));
    expectColor(
        color(underSky(mesh("ply", "c.ply", diffuse(R"(<texture name="reflectance" type="vertexcolors"/>)")),
                       "0.6.0")),
        {0.5f, 0.25f, 0.125f});
}

const std::string kTwoMaterials =
    "v -1 -1 0\nv 0 -1 0\nv 0 1 0\nv -1 1 0\nv 1 -1 0\nv 1 1 0\nusemtl left\nf 1 2 3 4\n"
    "usemtl on the right\nf 2 5 6 3\n";
std::string named(const std::string& name, float reflectance) {
    return diffuse(fmt::format(R"(<rgb name="reflectance" value="{}"/>)", reflectance),
                   name.empty() ? "" : "name=\"" + name + "\"");
}

TEST_F(Cases, BsdfsOf06GoToTheFacesOfTheirMaterial) {
    folder_.write("two.obj", kTwoMaterials);
    const auto expectSides = [&](const std::string& bsdfs, float onLeft, float onRight) {
        SCOPED_TRACE(bsdfs);
        const std::vector<float> image =
            render(folder_.write("scene.xml", underSky(mesh("obj", "two.obj", bsdfs), "0.6.0")));
        expectGray(meanOf(image, 0, 7), onLeft);
        expectGray(meanOf(image, 9, 16), onRight);
    };
    const std::string left = named("left", 0.2f), right = named("on the right", 0.6f);
    expectSides(left + right, 0.2f, 0.6f);
    expectSides(left, 0.2f, 0.5f);                     // Mitsuba's default for the others
    expectSides(named("", 0.8f) + right, 0.8f, 0.6f);  // without a name: all of them
    expectSides(right + named("", 0.8f), 0.8f, 0.8f);  // the last one holds
    expectSides(named("bsdf", 0.3f), 0.3f, 0.3f);      // a name that is no material's, of the only one
    EXPECT_THAT(load(underSky(mesh("obj", "two.obj", left + named("middle", 1)), "0.6.0")).warnings,
                Contains(HasSubstr("\"middle\"")));
    EXPECT_THAT(error(underSky(mesh("obj", "two.obj", left + right))), HasSubstr("<bsdf>"));
}

TEST_F(Cases, PointersOfGitLfsAreNamed) {
    const std::string pointer =
        "version https://git-lfs.github.com/spec/v1\noid sha256:" + std::string(64, '0') + "\nsize 1234\n";
    for (const char* file : {"a.obj", "a.ply", "a.serialized", "a.png", "a.exr", "a.xml", "a.spd"})
        folder_.write(file, pointer);
    const auto isNamed = AllOf(HasSubstr("scene.xml:"), HasSubstr("Git LFS"), HasSubstr("git lfs pull"));
    for (const char* type : {"obj", "ply", "serialized"})
        EXPECT_THAT(error(underSky(mesh(type, fmt::format("a.{}", type), kHalf))), isNamed) << type;
    EXPECT_THAT(error(underSky(quad(diffuse(bitmap("", "a.png"))))), isNamed);
    EXPECT_THAT(error(scene("<sensor type=\"perspective\"/><emitter type=\"envmap\">" +
                            text("filename", "a.exr") + "</emitter>")),
                isNamed);
    EXPECT_THAT(error(underSky("<include filename=\"a.xml\"/>")), isNamed);
    EXPECT_THAT(error(underSky(quad(diffuse("<spectrum name=\"reflectance\" filename=\"a.spd\"/>")))),
                isNamed);
    EXPECT_THAT(errorOf([&] { loadScene(folder_.path() / "a.xml", {}); }), HasSubstr("Git LFS"));
}

}  // namespace
}  // namespace metrolux::core::test
