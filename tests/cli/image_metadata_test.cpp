/// What an EXR says of itself: windows, alpha, camera, options; and `metrolux info`, which shows it.

#include "command.h"
#include "image/cryptomatte.h"
#include "image/image_io.h"
#include "render/aov.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <sstream>

namespace metrolux::core::cli {
namespace {

using testing::HasSubstr;

class ImageMetadataTest : public CliTest {
  protected:
    nlohmann::json infoOf(const std::string& image) const {
        const Outcome outcome = run({"info", image, "--json"});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return nlohmann::json::parse(outcome.out);
    }
};

TEST_F(ImageMetadataTest, ACropHasItsPlaceInTheFullImage) {
    ASSERT_EQ(run({"render", "scene.xml", "-i", "path", "--passes", "2", "--crop", "3,5,10,7", "-o", "a.exr",
                   "-o", "a.png"})
                  .status,
              0);
    const ImageData image = readImage(folder / "a.exr", false);
    EXPECT_EQ(image.width, 10);
    EXPECT_EQ(image.height, 7);
    EXPECT_EQ(image.place.x, 3);
    EXPECT_EQ(image.place.y, 5);
    EXPECT_EQ(image.place.fullWidth, 24);
    EXPECT_EQ(image.place.fullHeight, 16);
    EXPECT_EQ(infoOf("a.exr")["window"],
              (nlohmann::json{{"x", 3}, {"y", 5}, {"full_width", 24}, {"full_height", 16}}));
    EXPECT_FALSE(readImage(folder / "a.png", false).place.isCrop()) << "PNG has no windows";
    ASSERT_EQ(run({"render", "scene.xml", "-i", "path", "--passes", "2", "-o", "whole.exr"}).status, 0);
    EXPECT_FALSE(readImage(folder / "whole.exr", false).place.isCrop());
    EXPECT_FALSE(infoOf("whole.exr").contains("window"));
}

TEST_F(ImageMetadataTest, PartsOfACropAreMergedToItsPlace) {
    for (const char* part : {"0", "1"})
        ASSERT_EQ(run({"render", "scene.xml", "-i", "path", "--passes", "2", "--crop", "3,5,10,7", "--slices",
                       "2", "--only-slices", part, "--checkpoint", part})
                      .status,
                  0);
    ASSERT_EQ(run({"merge", "0", "1", "-o", "a.exr"}).status, 0);
    EXPECT_EQ(infoOf("a.exr")["window"]["full_width"], 24);
}

TEST_F(ImageMetadataTest, AlphaIsTheShareOfAPixelThatShowsSomething) {
    write("ball.xml", R"(<scene version="3.0.0"><sensor type="perspective">
<film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film>
<transform name="to_world"><lookat origin="0 0 4" target="0 0 0" up="0 1 0"/></transform></sensor>
<shape type="sphere"/><emitter type="constant"/></scene>)");
    ASSERT_EQ(
        run({"render", "ball.xml", "-i", "path", "--passes", "1", "-o", "a.exr", "--aov", "alpha"}).status,
        0);
    const ImageData image = readImage(folder / "a.exr", false);
    ASSERT_EQ(image.channels, 4);
    EXPECT_EQ(image.at(0, 0)[3], 0);
    EXPECT_EQ(image.at(8, 8)[3], 1);
    EXPECT_GT(image.at(0, 0)[0], 0) << "colors are not multiplied by it";
    const auto isEdge = [&](int i) {
        return image.pixels[size_t(4 * i + 3)] > 0 && image.pixels[size_t(4 * i + 3)] < 1;
    };
    int edges = 0;
    for (int i = 0; i < 256; ++i) edges += isEdge(i);
    EXPECT_GT(edges, 8);
    // Without alpha nothing else changes.
    ASSERT_EQ(run({"render", "ball.xml", "-i", "path", "--passes", "1", "-o", "b.exr"}).status, 0);
    EXPECT_EQ(readImage(folder / "b.exr", false).channels, 3);
    EXPECT_EQ(run({"compare", "a.exr", "b.exr"}).status, 0);
}

TEST_F(ImageMetadataTest, MattesOfObjectsAndMaterialsAreInTheFile) {
    write("two.xml", R"(<scene version="3.0.0"><sensor type="perspective">
<film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film>
<transform name="to_world"><lookat origin="0 0 4" target="0 0 0" up="0 1 0"/></transform></sensor>
<bsdf type="diffuse" id="paint"/><shape type="sphere" id="ball"><ref id="paint"/></shape>
<shape type="rectangle" id="wall"><transform name="to_world"><scale value="9"/><translate z="-2"/></transform>
<ref id="paint"/></shape><emitter type="constant"/></scene>)");
    const Outcome outcome = run({"render", "two.xml", "-i", "path", "--passes", "1", "-o", "a.exr", "--aov",
                                 "crypto_object,crypto_material,object,material,position,uv,motion"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto idOf = [](const char* name) { return std::bit_cast<float>(cryptomatteId(name)); };
    const ImageLayer objects = readLayer(folder / "a.exr", "crypto_object00"),
                     materials = readLayer(folder / "a.exr", "crypto_material00");
    ASSERT_EQ(objects.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
    const float *corner = objects.pixels.data(), *middle = &objects.pixels[size_t(4 * (8 * 16 + 8))];
    EXPECT_EQ(corner[0], idOf("wall"));
    EXPECT_NEAR(corner[1], 1, 1e-5);
    EXPECT_EQ(corner[3], 0);
    EXPECT_EQ(middle[0], idOf("ball"));
    int edges = 0;
    for (size_t i = 0; i < 256; ++i) {
        const float* pixel = &objects.pixels[4 * i];
        EXPECT_NEAR(pixel[1] + pixel[3], 1, 1e-5);
        EXPECT_GE(pixel[1], pixel[3]);
        edges += pixel[3] > 0;
        EXPECT_EQ(materials.pixels[4 * i], idOf("paint"));
        EXPECT_NEAR(materials.pixels[4 * i + 1], 1, 1e-5);
    }
    EXPECT_GT(edges, 8);
    const std::string said = infoOf("a.exr")["metadata"].dump();
    for (const char* text : {"uint32_to_float32", "MurmurHash3_32", "ball", "wall", "paint"})
        EXPECT_THAT(said, HasSubstr(text));
    // The image is the same with them.
    ASSERT_EQ(run({"render", "two.xml", "-i", "path", "--passes", "1", "-o", "b.exr"}).status, 0);
    EXPECT_EQ(readImage(folder / "a.exr", false).pixels, readImage(folder / "b.exr", false).pixels);
}

TEST_F(ImageMetadataTest, HelpNamesEveryLayer) {
    std::istringstream names(aovNames());
    const std::string help = run({"render", "--help"}).out;
    for (std::string name; std::getline(names >> std::ws, name, ',');)
        EXPECT_THAT(help, testing::ContainsRegex("[ \n]" + name + "[,\n]"));
}

TEST_F(ImageMetadataTest, OptionsAndCameraAreInTheFile) {
    ASSERT_EQ(run({"render", "scene.xml", "-i", "vcm", "--passes", "3", "--seed", "7", "--radius", "0.1",
                   "-o", "a.exr"})
                  .status,
              0);
    const nlohmann::json info = infoOf("a.exr");
    EXPECT_EQ(info["format"], "openexr");
    EXPECT_EQ(info["width"], 24);
    EXPECT_EQ(info["channels"], (nlohmann::json{"R", "G", "B"}));
    const nlohmann::json& m = info["metadata"];
    EXPECT_EQ(m["metrolux:passes"], 3);
    EXPECT_EQ(m["metrolux:integrator"], "vcm");
    const nlohmann::json options = nlohmann::json::parse(std::string(m["metrolux:options"]));
    EXPECT_EQ(options["seed"], 7);
    EXPECT_EQ(options["parameters"]["radius"], 0.1);
    // OpenEXR's standard attributes.
    for (const char* name : {"worldToCamera", "worldToNDC"}) EXPECT_EQ(m[name].size(), 16u) << m.dump(2);

    const Outcome people = run({"info", "a.exr"});
    EXPECT_EQ(people.status, 0);
    for (const char* text : {"openexr, 24x16 pixels", "channels", "metrolux:passes", "worldToCamera"})
        EXPECT_THAT(people.out, HasSubstr(text));
}

}  // namespace
}  // namespace metrolux::core::cli
