/// Elements of a Mitsuba scene to models and textures: names, defaults and errors. (The models are tested on
/// their own.)
#include "bsdf_checks.h"
#include "image/image_io.h"
#include "io/mitsuba/context.h"
#include "paths.h"
#include "scattering/fresnel.h"
#include "scattering/ior_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace metrolux::core::mitsuba {
namespace {

using test::flatInteraction;
using ::testing::HasSubstr;
using Value = decltype(Property::value);

/// An element by hand; the parser is tested elsewhere.
struct Builder {
    std::shared_ptr<Element> element = std::make_shared<Element>();

    Builder(const std::string& tag, const std::string& type) {
        element->tag = tag;
        element->type = type;
        element->location = {"scene.xml", 7};
    }
    Builder& with(const std::string& name, Value value) {
        Property p;
        p.value = std::move(value);
        p.location = {"scene.xml", 8};
        element->named.emplace_back(name, std::move(p));
        return *this;
    }
    Builder& with(const std::string& name, const char* text) { return with(name, Value(std::string(text))); }
    Builder& with(const std::string& name, const Builder& child) {
        return with(name, Value(ElementPtr(child.element)));
    }
    Builder& containing(const Builder& child) {
        Property p;
        p.value = ElementPtr(child.element);
        element->children.push_back(std::move(p));
        return *this;
    }
};
Builder bsdf(const std::string& type) { return {"bsdf", type}; }
Builder texture(const std::string& type) { return {"texture", type}; }

BsdfPtr build(const Builder& b) {
    LoadContext context;
    return makeBsdf(*b.element, context);
}
std::string errorOf(const Builder& b) {
    try {
        build(b);
    } catch (const Error& e) {
        return e.what();
    }
    return "no error";
}

/// Weight of the lobe that stays on the side of `known`, or of the one that crosses, times its probability.
float deltaEnergy(const Bsdf& model, bool transmitted) {
    CounterRng rng(1);
    for (int i = 0; i < 2000; ++i) {
        const float uLobe = rng.next1D();
        const auto s =
            model.sample(flatInteraction(), {0, 0, 1}, TransportMode::Importance, uLobe, rng.next2D());
        if (s && s->delta && s->transmitted == transmitted) return s->weight.y * s->pdfForward;
    }
    return 0;
}
float normalReflectance(float eta) { return sqr((eta - 1) / (eta + 1)); }

TEST(BsdfPlugins, DefaultsOfEveryType) {
    for (const char* type :
         {"diffuse", "dielectric", "thindielectric", "roughdielectric", "conductor", "roughconductor",
          "plastic", "roughplastic", "principled", "principledthin", "phong", "ward", "null"})
        EXPECT_TRUE(build(bsdf(type))) << type;
    for (const char* type : {"twosided", "mask"})
        EXPECT_TRUE(build(bsdf(type).containing(bsdf("diffuse")))) << type;
    EXPECT_TRUE(build(bsdf("blendbsdf").containing(bsdf("diffuse")).containing(bsdf("plastic"))));
    const Builder flat = texture("rawconstant").with("value", Vec3f(0.5f, 0.5f, 1));
    EXPECT_TRUE(build(bsdf("normalmap").with("normalmap", flat).containing(bsdf("diffuse"))));
    EXPECT_TRUE(build(bsdf("bumpmap").containing(flat).containing(bsdf("diffuse"))));
    EXPECT_FLOAT_EQ(build(bsdf("diffuse"))->albedo(flatInteraction()).x, 0.5f);
    EXPECT_NEAR(deltaEnergy(*build(bsdf("conductor")), false), 1, 1e-5) << "material none is a mirror";
    EXPECT_NEAR(deltaEnergy(*build(bsdf("dielectric")), false), normalReflectance(1.5046f / 1.000277f), 1e-5);
}

TEST(BsdfPlugins, IndicesOfRefraction) {
    const Builder named = bsdf("dielectric").with("int_ior", "diamond").with("ext_ior", "vacuum");
    EXPECT_NEAR(deltaEnergy(*build(named), false), normalReflectance(2.419f), 1e-5);
    const Builder numbers = bsdf("dielectric").with("int_ior", 1.8).with("ext_ior", int64_t{1});
    EXPECT_NEAR(deltaEnergy(*build(numbers), true), 1 - normalReflectance(1.8f), 1e-5);
    EXPECT_THAT(errorOf(bsdf("dielectric").with("int_ior", "glas")), HasSubstr("acrylic glass"));
    EXPECT_THAT(errorOf(bsdf("dielectric").with("int_ior", -1.0)), HasSubstr("positive"));
}

TEST(BsdfPlugins, Metals) {
    const float gold = fresnelConductor(1, namedConductor("Au")->eta, namedConductor("Au")->k).y;
    EXPECT_NEAR(deltaEnergy(*build(bsdf("conductor").with("material", "Au")), false), gold, 1e-5);
    const Builder given =
        bsdf("conductor").with("eta", RgbValue{Rgb(0, 1, 0)}).with("k", RgbValue{Rgb(0, 2, 0)});
    EXPECT_NEAR(deltaEnergy(*build(given), false), 0.5f, 1e-5);  // ((n-1)^2 + k^2) / ((n+1)^2 + k^2)
    EXPECT_THAT(errorOf(bsdf("conductor").with("material", "Au").with("k", 1.0)),
                HasSubstr("one of the two"));
    EXPECT_THAT(errorOf(bsdf("conductor").with("material", "gold")), HasSubstr("Au"));
    Builder old = bsdf("conductor");
    old.element->version = 0;
    const float copper = fresnelConductor(1, namedConductor("Cu")->eta, namedConductor("Cu")->k).y;
    EXPECT_NEAR(deltaEnergy(*build(old), false), copper, 1e-5) << "0.6 defaults to copper";
}

TEST(BsdfPlugins, NestingAndOrder) {
    const auto gray = [](double v) { return bsdf("diffuse").with("reflectance", v); };
    const BsdfPtr blend =
        build(bsdf("blendbsdf").with("weight", 0.25).containing(gray(0)).containing(gray(1)));
    EXPECT_NEAR(blend->albedo(flatInteraction()).x, 0.25f, 1e-6);
    const BsdfPtr mask = build(bsdf("mask").with("opacity", 0.75).with("bsdf", gray(0)));
    EXPECT_NEAR(mask->albedo(flatInteraction()).x, 0.25f, 1e-6);
    EXPECT_NEAR(deltaEnergy(*mask, true), 0.25f, 1e-6);
    EXPECT_THAT(errorOf(bsdf("mask")), HasSubstr("found 0 nested"));
    EXPECT_THAT(errorOf(bsdf("twosided").containing(bsdf("dielectric"))), HasSubstr("scene.xml:7"));
}

TEST(BsdfPlugins, SharedElementsAreBuiltOnce) {
    LoadContext context;
    const Builder shared = bsdf("diffuse");
    EXPECT_EQ(makeBsdf(*shared.element, context), makeBsdf(*shared.element, context));
}

TEST(BsdfPlugins, UnknownTypesAndProperties) {
    EXPECT_THAT(errorOf(bsdf("rougconductor")), HasSubstr("did you mean \"roughconductor\"?"));
    EXPECT_THAT(errorOf(bsdf("diffuse").with("reflectence", 0.3)),
                HasSubstr("did you mean \"reflectance\"?"));
    EXPECT_THAT(errorOf(bsdf("roughconductor").with("alpha_u", 0.3)), HasSubstr("alpha_v"));
    EXPECT_THAT(errorOf(bsdf("roughplastic").with("distribution", "phong")), HasSubstr("ggx"));
    LoadContext context;
    context.lenient = true;
    EXPECT_FLOAT_EQ(makeBsdf(*bsdf("hair").element, context)->albedo(flatInteraction()).x, 0.5f);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_THAT(context.warnings[0], HasSubstr("scene.xml:7"));
}

TEST(TextureProperties, ValuesOfAllKinds) {
    LoadContext context;
    Builder b = bsdf("any").with("number", 0.25).with("rgb", RgbValue{Rgb(0.1f, 0.2f, 2.0f)});
    b.with("texture", texture("checkerboard").with("color0", 1.4).with("color1", 0.0)).with("text", "red");
    const Element& e = *b.element;
    const SurfaceInteraction si = flatInteraction({0.7f, 0.2f});
    EXPECT_EQ(textureProperty(e, "absent", context, Rgb(0.3f))->rgb(si), Rgb(0.3f));
    EXPECT_EQ(textureProperty(e, "number", context, Rgb(0.3f))->rgb(si), Rgb(0.25f));
    EXPECT_EQ(textureProperty(e, "rgb", context, Rgb(0.3f))->rgb(si), Rgb(0.1f, 0.2f, 1.0f))
        << "a reflectance is limited";
    EXPECT_EQ(context.warnings.size(), 1u) << "and that is said";
    EXPECT_EQ(emissionProperty(e, "rgb", context, Rgb(0.3f))->rgb(si), Rgb(0.1f, 0.2f, 2.0f));
    EXPECT_EQ(unboundedColor(e, "rgb", context, Rgb(0.3f)), Rgb(0.1f, 0.2f, 2.0f));
    EXPECT_EQ(scalarTextureProperty(e, "texture", context, 0.3f)->scalar(si), 1.4f);
    EXPECT_THROW(textureProperty(e, "text", context, Rgb(0.3f)), Error);
    EXPECT_THROW(unboundedColor(e, "texture", context, Rgb(0.3f)), Error);
}

TEST(TexturePlugins, BitmapFile) {
    const std::filesystem::path file = std::filesystem::path(METROLUX_BINARY_DIR) / "plugin_texture_test.exr";
    ImageData image;
    image.width = 2;
    image.height = 1;
    image.channels = 3;
    image.pixels = {1, 0, 0, 0, 2, 0};
    writeExr(file, image);
    const auto bitmap = [&] { return texture("bitmap").with("filename", file.string().c_str()); };
    const auto make = [](const Builder& b) {
        LoadContext context;
        return makeTexture(*b.element, context);
    };
    Builder nearest = bitmap().with("filter_type", "nearest").with("raw", true);
    nearest.with("to_uv", Transform::translate(Vec3f(0.5f, 0, 0)));
    EXPECT_EQ(make(nearest)->rgb(flatInteraction({0.25f, 0.5f})), Rgb(0, 2, 0));
    EXPECT_EQ(make(bitmap())->mean(), Rgb(0.5f, 1, 0));
    EXPECT_THROW(make(bitmap().with("wrap_mode", "tile")), Error);
    EXPECT_THROW(make(texture("bitmap").with("filename", "none.png")), Error);
    EXPECT_THROW(make(texture("mesh_attribute").with("name", "color")), Error);
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace metrolux::core::mitsuba
