/// Bad scenes: each is refused with an Error that names the file, the line and the element, and nothing
/// worse.

#include "image/image_io.h"
#include "io/scene_loader.h"
#include "scene/scene.h"
#include "support.h"

#include <gmock/gmock.h>

#include <chrono>
#include <functional>

namespace metrolux::core {
namespace {

using test::errorOf;
using test::TemporaryFolder;
using testing::HasSubstr;

const std::string kSensor =
    R"(<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="4"/>
<integer name="height" value="4"/></film></sensor>
)";
const std::string kLight = "<emitter type=\"point\"/>\n";

/// A scene whose line 4 is the first of `body`.
std::string world(const std::string& body) {
    return fmt::format("<scene version=\"3.0.0\">{}{}{}\n</scene>", kSensor, kLight, body);
}
std::string shape(const std::string& content) {
    return world(fmt::format("<shape type=\"sphere\">{}</shape>", content));
}
std::string mesh(const std::string& type, const std::string& file) {
    return world(fmt::format(R"(<shape type="{}"><string name="filename" value="{}"/></shape>)", type, file));
}
std::string bitmap(const std::string& file) {
    return world(fmt::format(R"(<bsdf type="diffuse"><texture name="reflectance" type="bitmap">
        <string name="filename" value="{}"/></texture></bsdf>)",
                             file));
}
std::string film(const std::string& content) {
    return fmt::format(
        R"(<scene version="3.0.0">{}<sensor type="perspective"><film type="hdrfilm">{}</film></sensor>
        </scene>)",
        kLight, content);
}

std::string chain(int length) {
    std::string body;
    for (int i = 0; i < length; ++i)
        body += fmt::format("<bsdf type=\"twosided\" id=\"b{}\"><ref id=\"b{}\"/></bsdf>\n", i, i + 1);
    return body + fmt::format("<bsdf type=\"diffuse\" id=\"b{}\"/>", length);
}

/// Each BSDF refers twice to the next: two to the power of `levels` parts.
std::string doubling(int levels) {
    std::string body;
    for (int i = 0; i < levels; ++i)
        body += fmt::format(
            "<bsdf type=\"blendbsdf\" id=\"b{0}\"><ref id=\"b{1}\"/><ref id=\"b{1}\"/></bsdf>\n", i, i + 1);
    return body + fmt::format("<bsdf type=\"diffuse\" id=\"b{}\"/>", levels);
}

std::string doublingTextures(int levels) {
    std::string body;
    for (int i = 0; i < levels; ++i)
        body += fmt::format(
            "<texture type=\"checkerboard\" id=\"t{0}\"><ref name=\"color0\" id=\"t{1}\"/>"
            "<ref name=\"color1\" id=\"t{1}\"/></texture>\n",
            i, i + 1);
    return body + fmt::format("<texture type=\"checkerboard\" id=\"t{}\"/>", levels);
}

std::string aliases(int count) {
    std::string body = "<bsdf type=\"diffuse\" id=\"a0\"/>\n";
    for (int i = 0; i < count; ++i) body += fmt::format("<alias id=\"a{}\" as=\"a{}\"/>", i, i + 1);
    return body + fmt::format("\n<shape type=\"cube\"><ref id=\"a{}\"/></shape>", count);
}

/// A polygon whose triangles each have all of many attributes.
std::string plyOfManyAttributes(int attributes, int corners) {
    std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uint int vertex_indices\n";
    std::string data = "end_header\n0 0 0\n1 0 0\n0 1 0\n" + std::to_string(corners);
    for (int i = 0; i < corners; ++i) data += fmt::format(" {}", i % 3);
    for (int i = 0; i < attributes; ++i) {
        header += fmt::format("property float a{}\n", i);
        data += " 1";
    }
    return header + data + "\n";
}

std::string objOfManyCorners(int corners) {
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
    for (int i = 0; i < corners; ++i) text += fmt::format(" {}", i % 3 + 1);
    return text + "\n";
}

std::string repeated(const std::string& text, int count) {
    std::string result;
    result.reserve(text.size() * static_cast<size_t>(count));
    for (int i = 0; i < count; ++i) result += text;
    return result;
}

std::string nested(int depth) {
    return world(repeated("<bsdf type=\"twosided\">", depth) + repeated("</bsdf>", depth));
}

std::string firstHalf(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    const std::string all((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    return all.substr(0, all.size() / 2);
}

ImageData gradient() {
    ImageData image;
    image.width = image.height = 32;
    image.channels = 3;
    for (int i = 0; i < 32 * 32 * 3; ++i)
        image.pixels.push_back(static_cast<float>((i * 7919) % 1000) / 1000.0f);
    return image;
}

struct Malformed {
    std::string name;
    std::string text;                   ///< of scene.xml
    std::vector<std::string> expected;  ///< parts of the message
    std::vector<std::pair<std::string, std::string>> files = {};
    std::function<void(const TemporaryFolder&)> prepare = nullptr;
    std::map<std::string, std::string> defines = {};
    uint64_t memoryBytes = 0;
};

const std::string kAscii =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

const std::vector<Malformed> kXml = {
    {"empty_file", "", {"scene.xml", "empty"}},
    {"binary_garbage", std::string("\x7f\x45\x4c\x46\x00\x01\xfe\xff\x80", 9), {"scene.xml:1"}},
    {"utf16", std::string("\xff\xfe<\0s\0", 6), {"scene.xml", "UTF-16"}},
    {"invalid_utf8", "<scene version=\"3.0.0\">\n<!-- \xc3\x28 -->\n</scene>", {"scene.xml:2", "UTF-8"}},
    {"plain_text", "hello", {"scene.xml"}},
    {"truncated_xml",
     "<scene version=\"3.0.0\">\n<bsdf type=\"diffuse\"",
     {"scene.xml:2", "not well-formed"}},
    {"mismatched_tags", "<scene version=\"3.0.0\">\n<bsdf type=\"diffuse\">\n</scene>", {"scene.xml:3"}},
    {"two_roots", "<scene version=\"3.0.0\"/>\n<scene version=\"3.0.0\"/>", {"scene.xml:2", "second root"}},
    {"other_root", "<svg version=\"1.1\"/>", {"scene.xml:1", "<svg>", "expected <scene"}},
    {"missing_version", "<scene>\n</scene>", {"scene.xml:1", "version"}},
    {"unknown_version", "<scene version=\"9.0\"/>", {"scene.xml:1", "9.0", "expected"}},
    {"text_between_tags",
     world("<bsdf type=\"diffuse\">0.5</bsdf>"),
     {"scene.xml:4", "<bsdf type=\"diffuse\">", "text"}},
    {"unknown_tag", world("<shap type=\"cube\"/>"), {"scene.xml:4", "<shap", "did you mean <shape>?"}},
    {"tag_outside_transform", world("<translate x=\"1\"/>"), {"scene.xml:4", "<translate>", "inside"}},
    {"unknown_attribute",
     world("<bsdf typ=\"diffuse\"/>"),
     {"scene.xml:4", "\"typ\"", "did you mean \"type\"?"}},
    {"missing_attribute", world("<bsdf/>"), {"scene.xml:4", "<bsdf>", "\"type\""}},
    {"attribute_twice", world("<bsdf type=\"a\" type=\"b\"/>"), {"scene.xml:4", "twice"}},
    {"property_without_name", shape("<float value=\"1\"/>"), {"scene.xml:4", "<float>", "\"name\""}},
    {"property_twice",
     shape("<float name=\"radius\" value=\"1\"/>\n<float name=\"radius\" value=\"2\"/>"),
     {"scene.xml:5", "radius", "second time", "scene.xml:4"}},
    {"child_in_property",
     shape("<float name=\"radius\" value=\"1\"><bsdf type=\"diffuse\"/></float>"),
     {"scene.xml:4", "<float name=\"radius\">"}},
    {"bad_float",
     shape("\n<float name=\"radius\" value=\"1.0.0\"/>"),
     {"scene.xml:5", "radius", "1.0.0", "number"}},
    {"nan_float", shape("<float name=\"radius\" value=\"nan\"/>"), {"scene.xml:4", "radius", "finite"}},
    {"overflowing_float",
     shape("<float name=\"radius\" value=\"1e999\"/>"),
     {"scene.xml:4", "radius", "1e999"}},
    {"bad_integer", film("<integer name=\"width\" value=\"4.5\"/>"), {"scene.xml:2", "width", "integer"}},
    {"bad_boolean",
     shape("<boolean name=\"flip_normals\" value=\"yes\"/>"),
     {"scene.xml:4", "\"true\" or \"false\""}},
    {"bad_rgb",
     world("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1 2\"/></bsdf>"),
     {"scene.xml:4", "<rgb name=\"reflectance\">", "one or three"}},
    {"bad_hex_color",
     world("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"#12345g\"/></bsdf>"),
     {"scene.xml:4", "#rrggbb"}},
    {"bad_spectrum",
     world("<bsdf type=\"diffuse\"><spectrum name=\"reflectance\" value=\"500:1 400:1\"/></bsdf>"),
     {"scene.xml:4", "ascending"}},
    {"spectrum_type",
     world("<bsdf type=\"diffuse\"><spectrum name=\"reflectance\" type=\"unifrm\"/></bsdf>"),
     {"scene.xml:4", "did you mean \"uniform\"?"}},
    {"spd_missing",
     world("<bsdf type=\"diffuse\"><spectrum name=\"reflectance\" filename=\"a.spd\"/></bsdf>"),
     {"scene.xml:4", "a.spd", "does not exist"}},
    {"spd_garbage",
     world("<bsdf type=\"diffuse\"><spectrum name=\"reflectance\" filename=\"a.spd\"/></bsdf>"),
     {"scene.xml:4", "a.spd", "line 2", "blue"},
     {{"a.spd", "400 1\n500 blue\n"}}},
    {"nan_transform",
     shape("<transform name=\"to_world\">\n<translate x=\"nan\"/></transform>"),
     {"scene.xml:5", "<translate>", "finite"}},
    {"singular_scale",
     shape("<transform name=\"to_world\">\n<scale x=\"0\"/></transform>"),
     {"scene.xml:4", "\"to_world\"", "singular"}},
    {"singular_matrix",
     shape("<transform name=\"to_world\"><matrix value=\"1 2 3 2 4 6 0 0 1\"/></transform>"),
     {"scene.xml:4", "\"to_world\"", "singular"}},
    {"short_matrix",
     shape("<transform name=\"to_world\"><matrix value=\"1 2 3\"/></transform>"),
     {"scene.xml:4", "<matrix>", "9 or 16"}},
    {"overflowing_transform",
     shape("<transform name=\"to_world\">" + repeated("<scale value=\"1e30\"/>", 12) + "</transform>"),
     {"scene.xml:4", "<scale>"}},
    {"zero_axis",
     shape("<transform name=\"to_world\"><rotate angle=\"3\"/></transform>"),
     {"scene.xml:4", "<rotate>"}},
    {"lookat_at_itself",
     shape(
         "<transform name=\"to_world\"><lookat origin=\"1 1 1\" target=\"1 1 1\" up=\"0 1 0\"/></transform>"),
     {"scene.xml:4", "<lookat>"}},
    {"lookat_up_parallel",
     shape(
         "<transform name=\"to_world\"><lookat origin=\"0 0 0\" target=\"0 1 0\" up=\"0 1 0\"/></transform>"),
     {"scene.xml:4", "<lookat>"}},
    {"unknown_transform",
     shape("<transform name=\"to_world\"><rotat angle=\"3\"/></transform>"),
     {"scene.xml:4", "<rotat>", "did you mean <rotate>?"}},
    {"vector_parts", shape("<point name=\"center\" x=\"1\"/>"), {"scene.xml:4", "center", "x, y and z"}},
    {"undefined_name", world("<bsdf type=\"$kind\"/>"), {"scene.xml:4", "$kind"}},
    {"unused_definition",
     world("<default name=\"spp\" value=\"1\"/>"),
     {"scene.xml", "-D ssp", "did you mean \"spp\"?"},
     {},
     nullptr,
     {{"ssp", "3"}}},
    {"nesting_of_10000", nested(10000), {"scene.xml:4", "256"}},
    {"nesting_of_300000", nested(300000), {"scene.xml:4", "256"}},
    {"long_chain_of_references", world(chain(5000)), {"scene.xml", "256", "references included"}},
    {"cyclic_references",
     world("<bsdf type=\"twosided\" id=\"a\"><ref id=\"b\"/></bsdf>\n<bsdf type=\"twosided\" id=\"b\"><ref "
           "id=\"a\"/></bsdf>"),
     {"scene.xml:", "cycle", "\"a\"", "\"b\""}},
    {"dangling_reference",
     world("<bsdf type=\"diffuse\" id=\"wood\"/>\n<shape type=\"cube\"><ref id=\"wod\"/></shape>"),
     {"scene.xml:5", "<ref id=\"wod\">", "did you mean \"wood\"?"}},
    {"dangling_alias", world("<alias id=\"a\" as=\"b\"/>"), {"scene.xml:4", "<alias id=\"a\">"}},
    {"duplicate_id",
     world("<bsdf type=\"diffuse\" id=\"a\"/>\n<bsdf type=\"diffuse\" id=\"a\"/>"),
     {"scene.xml:5", "\"a\"", "scene.xml:4"}},
    {"missing_include",
     world("<include filename=\"parts.xml\"/>"),
     {"scene.xml:4", "<include>", "parts.xml"}},
    {"cyclic_include",
     world("<include filename=\"a.xml\"/>"),
     {"a.xml:2", "<include>", "includes itself"},
     {{"a.xml", "<scene version=\"3.0.0\">\n<include filename=\"scene.xml\"/></scene>"}}},
    {"bad_included_file",
     world("<include filename=\"a.xml\"/>"),
     {"a.xml:2", "<flaot"},
     {{"a.xml", "<scene version=\"3.0.0\">\n<flaot name=\"a\" value=\"1\"/></scene>"}}},
    {"named_include_of_a_scene",
     world("<include filename=\"a.xml\" name=\"part\"/>"),
     {"a.xml:1", "<scene>", "\"part\""},
     {{"a.xml", "<scene version=\"3.0.0\"/>"}}},
    {"include_depth",
     world("<include filename=\"i0.xml\"/>"),
     {".xml:1", "nested more than"},
     {},
     [](const TemporaryFolder& folder) {
         for (int i = 0; i < 40; ++i)
             folder.write(
                 fmt::format("i{}.xml", i),
                 fmt::format(R"(<scene version="3.0.0"><include filename="i{}.xml"/></scene>)", i + 1));
     }},
    {"missing_folder", world("<path value=\"nowhere\"/>"), {"scene.xml:4", "nowhere", "does not exist"}},
    {"path_inside_shape", shape("<path value=\".\"/>"), {"scene.xml:4", "<path>"}},
};

const std::vector<Malformed> kPlugins = {
    {"no_sensor", "<scene version=\"3.0.0\">\n</scene>", {"scene.xml:1", "no <sensor>"}},
    {"film_of_no_size",
     film("<integer name=\"width\" value=\"0\"/>"),
     {"scene.xml:2", "<film type=\"hdrfilm\"", "width"}},
    {"huge_film",
     film("<integer name=\"width\" value=\"100000\"/><integer name=\"height\" value=\"100000\"/>"),
     {"scene.xml:2", "<film", "100000"}},
    {"width_of_64_bits",
     film("<integer name=\"width\" value=\"9223372036854775807\"/>"),
     {"scene.xml:2", "width"}},
    {"unknown_bsdf",
     world("<bsdf type=\"difuse\"/>"),
     {"scene.xml:4", "difuse", "did you mean \"diffuse\"?"}},
    {"unknown_shape", world("<shape type=\"spere\"/>"), {"scene.xml:4", "did you mean \"sphere\"?"}},
    {"unknown_emitter", world("<emitter type=\"spott\"/>"), {"scene.xml:4", "did you mean \"spot\"?"}},
    {"unknown_texture", world("<texture type=\"bitmp\"/>"), {"scene.xml:4", "did you mean \"bitmap\"?"}},
    {"unknown_sensor",
     "<scene version=\"3.0.0\">\n<sensor type=\"perspectiv\"/></scene>",
     {"scene.xml:2", "did you mean \"perspective\"?"}},
    {"unknown_property",
     world("<bsdf type=\"diffuse\">\n<rgb name=\"reflectanc\" value=\"1\"/></bsdf>"),
     {"scene.xml:5", "<bsdf type=\"diffuse\"", "reflectanc", "did you mean \"reflectance\"?"}},
    {"property_of_scene", world("<float name=\"gain\" value=\"1\"/>"), {"scene.xml:4", "<scene>", "gain"}},
    {"wrong_type_of_property",
     shape("<string name=\"radius\" value=\"big\"/>"),
     {"scene.xml:4", "radius", "big"}},
    {"negative_depth",
     world("<integrator type=\"path\"><integer name=\"max_depth\" value=\"-7\"/></integrator>"),
     {"scene.xml:4", "max_depth", "-7"}},
    {"two_integrators",
     world("<integrator type=\"path\"/>\n<integrator type=\"path\"/>"),
     {"scene.xml:5", "second"}},
    {"emitter_in_bsdf",
     world("<bsdf type=\"diffuse\"><emitter type=\"area\"/></bsdf>"),
     {"scene.xml:4", "<emitter"}},
    {"point_light_in_shape", shape("<emitter type=\"point\"/>"), {"scene.xml:4"}},
    {"reference_of_wrong_kind",
     world("<bsdf type=\"twosided\"><ref id=\"s\"/></bsdf><shape type=\"sphere\" id=\"s\"/>"),
     {"scene.xml:4", "<bsdf type=\"twosided\""}},
    {"twosided_without_content", world("<bsdf type=\"twosided\"/>"), {"scene.xml:4", "twosided"}},
    {"zero_area_emitter",
     world("<shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/><emitter type=\"area\"/></shape>"),
     {"scene.xml:4"},
     {{"a.ply", kAscii + "0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n"}}},
    {"projective_instance",
     world(
         "<shape type=\"shapegroup\" id=\"g\"><shape type=\"cube\"/></shape>\n<shape type=\"instance\"><ref "
         "id=\"g\"/><transform name=\"to_world\"><matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1\"/>"
         "</transform></shape>"),
     {"scene.xml:5", "<shape type=\"instance\">", "affine"}},
    {"two_environments",
     world("<emitter type=\"constant\"/>\n<emitter type=\"constant\"/>"),
     {"scene.xml:5", "environment", "scene.xml:4"}},
    {"negative_radius", shape("<float name=\"radius\" value=\"-1\"/>"), {"scene.xml:4", "radius"}},
    {"missing_mesh", mesh("obj", "a.obj"), {"scene.xml:4", "a.obj", "does not exist"}},
    {"mesh_is_a_folder", mesh("obj", "."), {"scene.xml:4", "folder"}},
    {"truncated_ply", mesh("ply", "a.ply"), {"scene.xml:4", "a.ply"}, {{"a.ply", kAscii + "0 0 0\n1 0 0\n"}}},
    {"ply_index_out_of_range",
     mesh("ply", "a.ply"),
     {"scene.xml:4", "a.ply"},
     {{"a.ply", kAscii + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"}}},
    {"ply_of_nan",
     mesh("ply", "a.ply"),
     {"scene.xml:4", "a.ply"},
     {{"a.ply", kAscii + "nan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"}}},
    {"ply_declares_too_much",
     mesh("ply", "a.ply"),
     {"scene.xml:4", "a.ply"},
     {{"a.ply",
       "ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\nabcdefgh"}}},
    {"obj_index_out_of_range",
     mesh("obj", "a.obj"),
     {"scene.xml:4", "a.obj"},
     {{"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"}}},
    {"empty_obj", mesh("obj", "a.obj"), {"scene.xml:4", "a.obj"}, {{"a.obj", ""}}},
    {"serialized_garbage",
     mesh("serialized", "a.serialized"),
     {"scene.xml:4", "a.serialized"},
     {{"a.serialized", "this is no mesh at all, only text"}}},
    {"serialized_header_only",
     mesh("serialized", "a.serialized"),
     {"scene.xml:4", "a.serialized"},
     {{"a.serialized", std::string("\x1c\x04\x04\x00\x00\x00\x00\x00\x00\x00\x00\x00\x01\x00\x00\x00", 16)}}},
    {"missing_image", bitmap("a.png"), {"scene.xml:4", "a.png", "does not exist"}},
    {"empty_image", bitmap("a.png"), {"scene.xml:4", "a.png"}, {{"a.png", ""}}},
    {"text_as_exr", bitmap("a.exr"), {"scene.xml:4", "a.exr"}, {{"a.exr", "an image in words"}}},
    {"truncated_png",
     bitmap("a.png"),
     {"scene.xml:4", "a.png"},
     {},
     [](const TemporaryFolder& folder) {
         writePngRaw(folder.path() / "whole.png", gradient());
         folder.write("a.png", firstHalf(folder.path() / "whole.png"));
     }},
    {"truncated_exr",
     bitmap("a.exr"),
     {"scene.xml:4", "a.exr"},
     {},
     [](const TemporaryFolder& folder) {
         writeExr(folder.path() / "whole.exr", gradient());
         folder.write("a.exr", firstHalf(folder.path() / "whole.exr"));
     }},
    {"image_larger_than_its_file",
     bitmap("a.ppm"),
     {"scene.xml:4", "a.ppm", "10000x10000", "cannot hold"},
     {{"a.ppm", "P6\n10000 10000\n255\nabc"}}},
    {"image_of_too_many_pixels",
     bitmap("a.ppm"),
     {"scene.xml:4", "a.ppm", "100000x100000", "largest"},
     {{"a.ppm", "P6\n100000 100000\n255\nabc"}}},
    {"playlist_as_image",
     bitmap("a.png"),
     {"scene.xml:4", "a.png", "expected EXR"},
     {{"a.png", "#EXTM3U\n#EXTINF:1,\nhttp://127.0.0.1:9/a.ts\n"}}},
    {"video_as_image",
     bitmap("a.avi"),
     {"scene.xml:4", "a.avi", "expected EXR"},
     {{"a.avi", std::string("RIFF\x10\0\0\0AVI LIST", 16)}}},
    {"text_as_environment",
     world("<emitter type=\"envmap\"><string name=\"filename\" value=\"a.exr\"/></emitter>"),
     {"scene.xml:4", "a.exr"},
     {{"a.exr", "not light"}}},
};

/// What would take more memory or time than there is.
const std::vector<Malformed> kLimits = {
    {"blends_of_blends", world(doubling(60)), {"scene.xml:", "<bsdf type=\"blendbsdf\"", "4096 parts"}},
    {"textures_of_textures",
     world(doublingTextures(60)),
     {"scene.xml:", "<texture type=\"checkerboard\"", "4096 parts"}},
    {"long_chain_of_aliases", world(aliases(5000)), {"scene.xml:6", "<ref id=\"a5000\">", "256 aliases"}},
    {"memory_for_the_film",
     film("<integer name=\"width\" value=\"1000\"/><integer name=\"height\" value=\"1000\"/>"),
     {"scene.xml:2", "<film type=\"hdrfilm\">", "an image of 1000 x 1000 pixels would take 122.1 MiB"},
     {},
     nullptr,
     {},
     64 << 20},
    {"memory_for_elements",
     world(repeated("<bsdf type=\"diffuse\"/>\n", 1000)),
     {"scene.xml:", "<bsdf type=\"diffuse\">", "would take", "256.0 KiB"},
     {},
     nullptr,
     {},
     256 << 10},
    {"memory_for_instances",
     world("<shape type=\"shapegroup\" id=\"g\"><shape type=\"cube\"/></shape>\n" +
           repeated("<shape type=\"instance\"><ref id=\"g\"/></shape>\n", 1000)),
     {"scene.xml:", "<shape type=\"instance\">", "the instance would take"},
     {},
     nullptr,
     {},
     2500 << 10},
    {"memory_for_shapes",
     world(repeated("<shape type=\"sphere\"/>\n", 1000)),
     {"scene.xml:", "<shape type=\"sphere\">", "the shape would take"},
     {},
     nullptr,
     {},
     1500 << 10},
    {"memory_for_a_file",
     mesh("obj", "a.obj"),
     {"scene.xml:4", "a.obj", "the file would take"},
     {{"a.obj", std::string(100000, '#') + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"}},
     nullptr,
     {},
     64 << 10},
    {"memory_for_a_polygon",
     mesh("obj", "a.obj"),
     {"scene.xml:4", "a.obj", "the mesh would take"},
     {{"a.obj", objOfManyCorners(10000)}},
     nullptr,
     {},
     128 << 10},
    {"memory_for_attributes",
     mesh("ply", "a.ply"),
     {"scene.xml:4", "a.ply", "the faces would take"},
     {{"a.ply", plyOfManyAttributes(300, 3000)}},
     nullptr,
     {},
     512 << 10},
    {"memory_for_an_image",
     bitmap("a.ppm"),
     {"scene.xml:4", "a.ppm", "the image would take"},
     {{"a.ppm", "P6\n200 200\n255\n" + std::string(120000, 'a')}},
     nullptr,
     {},
     256 << 10},
};

class MalformedScene : public testing::TestWithParam<Malformed> {};

TEST_P(MalformedScene, IsRefusedWithItsPlace) {
    const Malformed& param = GetParam();
    const TemporaryFolder folder;
    for (const auto& [name, text] : param.files) folder.write(name, text);
    if (param.prepare) param.prepare(folder);
    LoadOptions options;
    options.defines = param.defines;
    options.memoryBytes = param.memoryBytes;
    const auto file = folder.write("scene.xml", param.text);
    const std::string message = errorOf([&] { Scene scene(loadScene(file, options)); });
    for (const std::string& part : param.expected) EXPECT_THAT(message, HasSubstr(part));
    EXPECT_LT(message.size(), 4000u);
}

std::string nameOf(const testing::TestParamInfo<Malformed>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Xml, MalformedScene, testing::ValuesIn(kXml), nameOf);
INSTANTIATE_TEST_SUITE_P(Limits, MalformedScene, testing::ValuesIn(kLimits), nameOf);
INSTANTIATE_TEST_SUITE_P(Plugins, MalformedScene, testing::ValuesIn(kPlugins), nameOf);

TEST(MalformedFile, IsRefused) {
    const TemporaryFolder folder;
    EXPECT_THAT(errorOf([&] { loadScene(folder.path(), {}); }), HasSubstr("folder"));
    EXPECT_THAT(errorOf([&] { loadScene(folder.path() / "absent.xml", {}); }), HasSubstr("absent.xml"));
    EXPECT_THAT(errorOf([&] { loadScene("", {}); }), HasSubstr("does not exist"));
    EXPECT_THAT(errorOf([&] { loadScene("/dev/null", {}); }), HasSubstr("/dev/null"));
}

TEST(Limits, OneReferenceAmongManyIsFoundAtOnce) {
    // A quarter of a million references in one element: a search among all for each would take minutes.
    const std::string text = world("<bsdf type=\"diffuse\" id=\"a\"/>" + repeated("<ref id=\"a\"/>", 250000));
    const TemporaryFolder folder;
    const auto file = folder.write("scene.xml", text);
    const auto start = std::chrono::steady_clock::now();
    loadScene(file, {});
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST(Limits, ScenesAreReadWithoutWriting) {
    const TemporaryFolder folder;
    const auto file = folder.write("scene.xml", fmt::format(R"(<scene version="0.6.0">
<sensor type="perspective"><film type="ldrfilm"><string name="filename" value="{0}/a"/>
</film></sensor>
<texture type="bitmap" id="t"><string name="filename" value="a.ppm"/><boolean name="cache" value="true"/></texture>
<shape type="sphere"><emitter type="area"/></shape></scene>)",
                                                            folder.path().string()));
    folder.write("a.ppm", "P6\n1 1\n255\nabc");
    LoadOptions options;
    options.lenient = true;
    const Scene scene(loadScene(file, options));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
}

/// Every prefix of a good scene is an Error or a scene, never a crash.
TEST(MalformedFile, AnyPrefixIsHandled) {
    const TemporaryFolder folder;
    const std::string text = world(R"(<default name="a" value="1"/><bsdf type="diffuse" id="b">
        <rgb name="reflectance" value="0.1, 0.2, 0.3"/></bsdf><shape type="sphere"><float name="radius" value="$a"/>
        <transform name="to_world"><lookat origin="0 0 0" target="0 0 1" up="0 1 0"/></transform><ref id="b"/></shape>)");
    EXPECT_NO_THROW(loadScene(folder.write("whole.xml", text), {}));
    for (size_t length = 0; length < text.size(); ++length) {
        const auto file = folder.write("scene.xml", text.substr(0, length));
        EXPECT_THAT(errorOf([&] { loadScene(file, {}); }), HasSubstr("scene.xml")) << "prefix of " << length;
    }
}

}  // namespace
}  // namespace metrolux::core
