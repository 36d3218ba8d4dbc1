/// pbrt scenes: materials, textures and spectra against closed forms, and scenes that Mitsuba's XML says too.

#include "io/mitsuba/xml_writer.h"
#include "pbrt_support.h"
#include "scattering/fresnel.h"
#include "scattering/ior_table.h"

#include <gmock/gmock.h>

#include <numbers>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;

/// A material on the quad under a white sky, seen almost from above.
Rgb inWhite(const std::string& material, int passes = 400) {
    return seenPbrt(pbrtScene("LightSource \"infinite\"\n" + material + "\n" + kQuad), passes);
}
/// The same as a closed body.
Rgb sphereInWhite(const std::string& material) {
    return seenPbrt(pbrtScene("LightSource \"infinite\"\n" + material + "\nShape \"sphere\"\n"), 400);
}

TEST(PbrtMaterials, ColorsOfADiffuseSurface) {
    expectGray(inWhite("Material \"diffuse\""), 0.5f);
    expectColor(inWhite("Material \"diffuse\" \"rgb reflectance\" [0.1 0.5 0.9]"), {0.1f, 0.5f, 0.9f});
    expectGray(inWhite("Material \"diffuse\" \"spectrum reflectance\" [300 0.3 900 0.3]"), 0.3f);
    const Rgb red = inWhite("Material \"diffuse\" \"spectrum reflectance\" [400 0 580 0 600 0.8 800 0.8]");
    EXPECT_GT(red.x, 5 * red.y);
    // A pure color of wider primaries lies outside of ours; gray is gray in all of them.
    for (const char* space : {"srgb", "rec2020", "dci-p3", "aces2065-1"})
        expectGray(inWhite(std::string("ColorSpace \"") + space +
                           "\" Material \"diffuse\" \"rgb reflectance\" [0.4 0.4 0.4]"),
                   0.4f);
    EXPECT_EQ(inWhite("ColorSpace \"rec2020\" Material \"diffuse\" \"rgb reflectance\" [0.5 0 0]").y, 0);
}

TEST(PbrtMaterials, BothSidesOfASurfaceReflect) {
    for (const char* material :
         {"Material \"diffuse\"", "Material \"coateddiffuse\" \"rgb reflectance\" [1 1 1]",
          "Material \"conductor\" \"rgb reflectance\" [0.5 0.5 0.5] \"float roughness\" 0.5"})
        EXPECT_GT(seenPbrt(pbrtScene("LightSource \"infinite\"\nReverseOrientation\n" +
                                     std::string(material) + "\n" + kQuad),
                           50)
                      .x,
                  0.2f);
}

TEST(PbrtMaterials, Metals) {
    expectColor(inWhite("Material \"conductor\" \"rgb reflectance\" [0.2 0.5 0.8]", 4), {0.2f, 0.5f, 0.8f});
    const auto f0 = [](const char* name) {
        const auto metal = namedConductor(name);
        return fresnelConductor(1, metal->eta, metal->k);
    };
    expectColor(inWhite("Material \"conductor\"", 4), f0("Cu"));
    expectColor(
        inWhite("Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"", 4),
        f0("Au"));
    expectGray(inWhite("Material \"conductor\" \"float eta\" 1.5 \"rgb k\" [0 0 0]", 4), 0.04f);
    // Roughness: alpha is its root. A wide lobe of one bounce loses light, a narrow one next to none.
    const std::string rough = "Material \"conductor\" \"rgb reflectance\" [0.9999 0.9999 0.9999] ";
    EXPECT_GT(inWhite(rough + "\"float roughness\" 0.0025").x, 0.99f);
    const float wide = inWhite(rough + "\"float roughness\" 0.25").x,
                same = inWhite(rough + "\"float roughness\" 0.5 \"bool remaproughness\" false").x;
    EXPECT_NEAR(wide, same, 0.02f);
    EXPECT_LT(wide, 0.98f);
}

TEST(PbrtMaterials, ClearAndCoatedOnesLoseNothing) {
    expectGray(sphereInWhite("Material \"dielectric\" \"float eta\" 1.5"), 1);
    expectGray(sphereInWhite("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\""), 1);
    expectGray(inWhite("Material \"thindielectric\""), 1);
    expectGray(sphereInWhite("Material \"interface\""), 1);
    expectGray(sphereInWhite("Material \"\""), 1);
    expectGray(inWhite("Material \"coateddiffuse\" \"rgb reflectance\" [1 1 1]"), 1);
    // With the metal's light to and fro the coat reflects more than its own 4 %.
    const float coated = inWhite("Material \"coatedconductor\" \"rgb reflectance\" [0.9 0.9 0.9]", 100).x;
    EXPECT_GT(coated, 0.8f);
    EXPECT_LT(coated, 1.01f);
}

TEST(PbrtMaterials, DiffuseTransmission) {
    const std::string leaf =
        "Material \"diffusetransmission\" \"rgb reflectance\" [0.3 0.2 0.1] \"rgb transmittance\" [0.1 0.4 "
        "0.5]\n";
    expectColor(inWhite(leaf, 2000), {0.4f, 0.6f, 0.6f});
    const auto lamp = [&](const char* z) {
        return seenPbrt(pbrtScene(std::string("LightSource \"point\" \"point3 from\" [0 0 ") + z +
                                  "] \"float scale\" 4\n" + leaf + kQuad),
                        2000);
    };
    const float by = 1 / std::numbers::pi_v<float>;
    expectColor(lamp("2"), Rgb(0.3f, 0.2f, 0.1f) * by);
    expectColor(lamp("-2"), Rgb(0.1f, 0.4f, 0.5f) * by);
}

TEST(PbrtMaterials, MixesNamesAndAlpha) {
    const std::string two =
        "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [0.8 0 0]\n"
        "MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [0 0.4 0]\n";
    expectColor(inWhite(two + "NamedMaterial \"b\""), {0, 0.4f, 0});
    expectColor(
        inWhite(two + "Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" 0.25", 2000),
        {0.6f, 0.1f, 0});
    const std::string black =
        "LightSource \"infinite\"\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n" + kQuad;
    expectGray(seenPbrt(pbrtScene(black.substr(0, black.size() - 1) + " \"float alpha\" 0.25\n"), 2000),
               0.75f);
    expectColor(inWhite("AttributeBegin Material \"diffuse\" \"rgb reflectance\" [1 0 0] AttributeEnd"),
                Rgb(0.5f));
    expectColor(inWhite("Attribute \"material\" \"rgb reflectance\" [0.1 0.2 0.3] Material \"diffuse\""),
                {0.1f, 0.2f, 0.3f});
}

/// 2 x 2 texels: red, green; blue, white.
ImageData fourTexels() { return {2, 2, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}}; }

Rgb textured(const std::string& texture) {
    return seenWithImage(fourTexels(),
                         pbrtScene("LightSource \"infinite\"\n" + texture +
                                   "\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n" + kQuad),
                         400);
}

TEST(PbrtTextures, ImagesStandUpright) {
    const auto at = [](const char* u, const char* v, const std::string& more = "") {
        return textured(fmt::format(
            "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"image.png\" \"string filter\" "
            "\"point\""
            " \"float uscale\" 0.01 \"float vscale\" 0.01 \"float udelta\" {} \"float vdelta\" {} {}",
            u, v, more));
    };
    expectColor(at("0.2", "0.8"), {1, 0, 0});
    expectColor(at("0.7", "0.8"), {0, 1, 0});
    expectColor(at("0.2", "0.2"), {0, 0, 1});
    expectColor(at("0.7", "0.2"), {1, 1, 1});
    expectColor(at("1.2", "0.8"), {1, 0, 0});
    expectColor(at("1.2", "0.8", "\"string wrap\" \"clamp\""), {0, 1, 0});
    expectColor(at("0.2", "0.8", "\"float scale\" 0.5"), {0.5f, 0, 0});
    expectColor(at("0.2", "0.8", "\"bool invert\" true"), {0, 1, 1});
}

TEST(PbrtTextures, OnASphereTheUpperEdgeIsAtItsPole) {
    // The pole is toward the camera, u = 0 toward +x.
    const std::string ball =
        "LightSource \"infinite\"\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"image.png\" "
        "\"string filter\" "
        "\"point\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n";
    const Rgb pole =
        seenWithImage(fourTexels(), pbrtScene(ball + "Translate -0.1 -0.1 0 Shape \"sphere\""), 50);
    expectColor(pole, {1, 0, 0});
    expectColor(
        seenWithImage(fourTexels(),
                      pbrtScene(ball + "Rotate 180 1 0 0 Translate -0.1 -0.1 0 Shape \"sphere\""), 50),
        {0, 0, 1});
    // A disk has its upper edge at the middle.
    expectColor(seenWithImage(fourTexels(), pbrtScene(ball + "Translate 0.1 0.1 0 Shape \"disk\""), 50),
                {0, 1, 0});
}

TEST(PbrtTextures, SumsAndProducts) {
    const std::string two =
        "Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [0.8 0.4 0.2]\n"
        "Texture \"f\" \"float\" \"constant\" \"float value\" 0.5\n"
        "Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"image.png\" \"string filter\" "
        "\"point\" \"float uscale\" "
        "0.01 \"float vscale\" 0.01 \"float udelta\" 0.2 \"float vdelta\" 0.8\n";
    expectColor(
        textured(two + "Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"a\" \"texture scale\" \"f\""),
        {0.4f, 0.2f, 0.1f});
    expectColor(
        textured(two + "Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"i\" \"float scale\" 0.3"),
        {0.3f, 0, 0});
    expectColor(textured(two + "Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"a\" \"texture tex2\" "
                               "\"i\" \"float amount\" 0.25"),
                {0.85f, 0.3f, 0.15f});
    expectColor(textured(two + "Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"i\" \"texture tex2\" "
                               "\"i\" \"texture amount\" \"f\""),
                {1, 0, 0});
}

TEST(PbrtTextures, TheFirstSquareOfACheckerboardHasItsFirstColor) {
    const std::string board =
        "Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [0.9 0 0] \"rgb tex2\" [0 0.9 0] "
        "\"float uscale\" 0.01 \"float vscale\" 0.01 ";
    expectColor(textured(board + "\"float udelta\" 0.5 \"float vdelta\" 0.5"), {0.9f, 0, 0});
    expectColor(textured(board + "\"float udelta\" 1.5 \"float vdelta\" 0.5"), {0, 0.9f, 0});
    expectColor(textured(board + "\"float udelta\" 1.5 \"float vdelta\" 1.5"), {0.9f, 0, 0});
    // As an opacity too.
    const std::string alpha =
        "LightSource \"infinite\"\nTexture \"o\" \"float\" \"checkerboard\" \"float uscale\" 0.01 \"float "
        "vscale\" 0.01\n"
        "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n" +
        kQuad.substr(0, kQuad.size() - 1);
    expectGray(seenPbrt(pbrtScene(alpha + " \"texture alpha\" \"o\"\n"), 20), 0);
}

TEST(PbrtMaterials, NamesOfVersionThree) {
    const std::pair<const char*, Rgb> cases[] = {
        {"Material \"matte\" \"rgb Kd\" [0.2 0.4 0.6]", {0.2f, 0.4f, 0.6f}},
        {"Material \"mirror\" \"rgb Kr\" [0.7 0.8 0.9]", {0.7f, 0.8f, 0.9f}},
        {"Material \"glass\"", Rgb(1.0f)},
    };
    for (const auto& [text, expected] : cases) {
        expectColor(sphereInWhite(text), expected);
        EXPECT_THAT(loadedPbrt(pbrtScene("LightSource \"infinite\"\n" + std::string(text) +
                                         " Shape \"sphere\"\nWorldEnd"))
                        .warnings,
                    testing::ElementsAre(HasSubstr("is of pbrt 3")))
            << text;
    }
    for (const char* text :
         {"Material \"plastic\" \"rgb Ks\" [0.2 0.2 0.2]", "Material \"uber\" \"rgb Kd\" [0.1 0.1 0.1]",
          "Material \"substrate\"", "Material \"metal\" \"float uroughness\" 0.1",
          "Material \"matte\" \"float sigma\" 20"})
        EXPECT_FALSE(
            loadedPbrt(pbrtScene("LightSource \"infinite\"\n" + std::string(text) + " Shape \"sphere\""))
                .shapes.empty());
}

const char* const kRoom = R"(# A twin of kRoomOfMitsuba.
LookAt 3 1 2  0 0 0.5  0 0 1
Camera "perspective" "float fov" 45
Film "rgb" "integer xresolution" 32 "integer yresolution" 24
PixelFilter "box"
WorldBegin
LightSource "infinite" "rgb L" [0.2 0.3 0.5] "float scale" 2
LightSource "point" "point3 from" [2 2 3] "rgb I" [5 5 5]
AttributeBegin
  Material "diffuse" "rgb reflectance" [0.5 0.4 0.3]
  Scale 2 2 1
  Shape "trianglemesh" "point3 P" [-1 -1 0  1 -1 0  1 1 0  -1 1 0] "integer indices" [0 1 2 0 2 3]
AttributeEnd
AttributeBegin
  Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k" "float roughness" 0.04
  Translate 0.6 0 0.4
  Shape "sphere" "float radius" 0.4
AttributeEnd
Material "dielectric"
AttributeBegin
  Translate 0 0.9 0.3
  Shape "sphere" "float radius" 0.3
AttributeEnd
Material "diffuse"
AreaLightSource "diffuse" "rgb L" [3 3 1]
Translate -0.6 0.5 0.3
Shape "disk" "float radius" 0.3
)";
const char* const kRoomOfMitsuba =
    R"(<integrator type="path"><integer name="max_depth" value="6"/></integrator>
<sensor type="perspective"><float name="fov" value="45"/><string name="fov_axis" value="smaller"/><float name="near_clip" value="0.00001"/>
<transform name="to_world"><scale x="-1"/><lookat origin="3,1,2" target="0,0,0.5" up="0,0,1"/></transform>
<film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="24"/><rfilter type="box"/></film></sensor>
<emitter type="constant"><rgb name="radiance" value="0.4,0.6,1"/></emitter>
<emitter type="point"><point name="position" value="2,2,3"/><rgb name="intensity" value="5"/></emitter>
<bsdf type="twosided" id="gray"><bsdf type="diffuse"/></bsdf>
<shape type="rectangle"><transform name="to_world"><scale value="2"/></transform><bsdf type="twosided">
<bsdf type="diffuse"><rgb name="reflectance" value="0.5,0.4,0.3"/></bsdf></bsdf></shape>
<shape type="sphere"><transform name="to_world"><translate x="0.6" z="0.4"/></transform><float name="radius" value="0.4"/>
<bsdf type="twosided"><bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.2"/>
<string name="distribution" value="ggx"/></bsdf></bsdf></shape>
<shape type="sphere"><transform name="to_world"><translate y="0.9" z="0.3"/></transform><float name="radius" value="0.3"/>
<bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>
<shape type="disk"><transform name="to_world"><scale value="0.3"/><translate x="-0.6" y="0.5" z="0.3"/></transform>
<emitter type="area"><rgb name="radiance" value="3,3,1"/></emitter><ref id="gray"/></shape>)";

TEST(Pbrt, ATwinOfAMitsubaSceneIsTheSamePicture) {
    const TemporaryFolder folder;
    const auto picture = [](const std::filesystem::path& file) {
        return RenderableScene(file, {}).render("vcm", 8, 1);
    };
    const std::vector<float> own = picture(folder.write("room.pbrt", kRoom)),
                             twin = picture(folder.write("room.xml", scene(kRoomOfMitsuba)));
    // The same random numbers and next to the same rays: what rounding sends another way is rare.
    ASSERT_EQ(own.size(), twin.size());
    size_t different = 0;
    for (size_t i = 0; i < own.size(); ++i)
        different += std::abs(own[i] - twin[i]) > 1e-3f * (own[i] + twin[i]);
    EXPECT_LT(different, own.size() / 50);
    EXPECT_NEAR(meanOf(own).y, meanOf(twin).y, 1e-3 * double(meanOf(own).y));
}

TEST(Pbrt, ConvertedScenesKeepTheirBits) {
    const TemporaryFolder folder;
    folder.write("image.png", encodePngRaw(fourTexels()));
    const std::string more = R"(Identity
Texture "t" "spectrum" "imagemap" "string filename" "image.png" "float uscale" 3 "float scale" 0.7
Texture "b" "float" "checkerboard" "float tex1" 0.1 "float tex2" 0.3
ObjectBegin "o" Material "coateddiffuse" "texture reflectance" "t" "float roughness" 0.1
Shape "sphere" "float zmax" 0.3 "float radius" 0.2 Material "conductor" "texture roughness" "b" Shape "disk" "float radius" 0.1 ObjectEnd
Rotate 33 1 0.2 0.1 Translate 0.1 0.2 0.9 ObjectInstance "o" Scale 1 -0.5 0.3 ObjectInstance "o"
AttributeBegin Identity LightSource "infinite" "string filename" "image.png" "float scale" 0.1 AttributeEnd
AttributeBegin Identity Rotate 40 1 1 1 LightSource "projection" "string filename" "image.png" "float fov" 40 "float scale" 3 AttributeEnd
Identity LightSource "spot" "point3 from" [1 1 4] "float scale" 9
Translate 1 2 3 Rotate 20 1 2 3 LightSource "goniometric" "string filename" "image.png" "float scale" 5
Material "mix" "string materials" ["x" "y"] "float amount" 0.3
)";
    std::string room = kRoom;
    room.replace(room.find("LightSource \"infinite\""),
                 std::string("LightSource \"infinite\" \"rgb L\" [0.2 0.3 0.5] \"float scale\" 2").size(),
                 "");
    const auto file =
        folder.write("room.pbrt", room +
                                      "MakeNamedMaterial \"x\" \"string type\" "
                                      "\"thindielectric\"\nMakeNamedMaterial \"y\" \"string type\" "
                                      "\"diffusetransmission\"\n" +
                                      more);
    const auto out = folder.path() / "room.xml";
    mitsuba::writeScene(parseSceneFile(file, {}), out);
    EXPECT_EQ(RenderableScene(out, {}).render("vcm", 2, 1), RenderableScene(file, {}).render("vcm", 2, 1));
}

}  // namespace
}  // namespace metrolux::core::test
