/// Elements of a Mitsuba scene to lights, cameras and films: names, defaults, overrides and errors.

#include "image/image_io.h"
#include "io/mitsuba/context.h"
#include "paths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace metrolux::core::mitsuba {
namespace {

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
        element->named.emplace_back(name, Property{std::move(value), {"scene.xml", 8}});
        return *this;
    }
    Builder& with(const std::string& name, const char* text) { return with(name, Value(std::string(text))); }
    Builder& with(const std::string& name, double value) { return with(name, Value(value)); }
    Builder& with(const std::string& name, int value) { return with(name, Value(int64_t(value))); }
    Builder& containing(const Builder& child) {
        element->children.push_back(Property{ElementPtr(child.element), {"scene.xml", 9}});
        return *this;
    }
};
Builder emitter(const std::string& type) { return {"emitter", type}; }
Builder film() { return {"film", "hdrfilm"}; }
Value rgb(float r, float g, float b) { return RgbValue{Rgb(r, g, b)}; }

LightPtr light(const Builder& b) {
    LoadContext context;
    return makeLight(*b.element, context);
}
/// A camera that looks along +z, with what it read besides.
struct Sensor {
    LoadContext context;
    SceneParts parts;
    CameraPtr camera;
};
Sensor sensor(const Builder& b, const FilmOverride& film = {}) {
    Sensor s;
    s.context.film = film;
    s.camera = makeCamera(*b.element, s.context, s.parts);
    return s;
}
Builder perspective() { return {"sensor", "perspective"}; }

template <class Action>
std::string errorOf(Action&& action) {
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    return "no error";
}

TEST(EmitterPlugins, pointAndItsPosition) {
    const LightPtr a =
        light(emitter("point").with("position", Vec3f(1, 2, 3)).with("intensity", rgb(4, 5, 6)));
    const auto c = a->connect({1, 2, 1}, {});
    EXPECT_EQ(c->point, Vec3f(1, 2, 3));
    EXPECT_NEAR((c->value - Rgb(1, 1.25f, 1.5f)).length(), 0, 1e-6);
    const LightPtr b = light(emitter("point").with("to_world", Transform::translate({1, 2, 3})));
    EXPECT_EQ(b->connect({0, 0, 0}, {})->point, Vec3f(1, 2, 3));
    EXPECT_NEAR(b->connect({1, 2, 2}, {})->value.x, 1, 1e-6) << "the intensity's default";
    const Builder both = emitter("point").with("position", Vec3f(1, 2, 3)).with("to_world", Transform());
    EXPECT_THAT(errorOf([&] { light(both); }), HasSubstr("expected one of them"));
}

TEST(EmitterPlugins, spotDefaults) {
    const LightPtr spot = light(emitter("spot").with("intensity", rgb(2, 2, 2)));
    const auto at = [&](float degrees) {
        const auto c = spot->connect({std::sin(radians(degrees)), 0, std::cos(radians(degrees))}, {});
        return c ? c->value.x : 0.0f;
    };
    EXPECT_NEAR(at(14.9f), 2, 1e-4);
    EXPECT_NEAR(at(17.5f), 1, 1e-3) << "half way between 3/4 of the cutoff and the cutoff of 20 degrees";
    EXPECT_EQ(at(20.1f), 0);
}

TEST(EmitterPlugins, directional) {
    const LightPtr a =
        light(emitter("directional").with("direction", Vec3f(0, -2, 0)).with("irradiance", rgb(3, 3, 3)));
    EXPECT_EQ(a->connect({0, 0, 0}, {})->wi, Vec3f(0, 1, 0));
    EXPECT_EQ(a->connect({0, 0, 0}, {})->value, Rgb(3.0f));
    const LightPtr b = light(emitter("directional").with("to_world", Transform::rotate({1, 0, 0}, 90)));
    EXPECT_NEAR((b->connect({0, 0, 0}, {})->wi - Vec3f(0, 1, 0)).length(), 0, 1e-6) << "+z is turned to -y";
}

TEST(EmitterPlugins, constantProjectorCollimated) {
    EXPECT_EQ(light(emitter("constant"))->environmentRadiance({0, 0, 1}), Rgb(1.0f));
    EXPECT_EQ(light(emitter("constant").with("radiance", rgb(1, 2, 3)))->environmentRadiance({0, 0, 1}),
              Rgb(1, 2, 3));
    const LightPtr projector = light(emitter("projector").with("fov", 90.0).with("irradiance", rgb(1, 1, 1)));
    EXPECT_NEAR(projector->connect({0, 0, 1}, {})->value.x, kPi, 1e-5);
    EXPECT_TRUE(projector->connect({0.99f, 0, 1}, {}));
    EXPECT_FALSE(projector->connect({1.01f, 0, 1}, {}));
    const LightPtr beam = light(emitter("collimated").with("power", rgb(1, 2, 3)));
    EXPECT_EQ(beam->sampleRay({}, {})->weight, Rgb(1, 2, 3));
    EXPECT_FALSE(beam->isConnectable());
}

TEST(EmitterPlugins, environmentMapFromAFile) {
    const std::filesystem::path folder = std::filesystem::path(METROLUX_BINARY_DIR) / "endpoint_plugins_test";
    std::filesystem::create_directories(folder);
    ImageData image{2, 3, 3, std::vector<float>(18, 0.5f)};
    image.pixels[6] = 4;  // second row, first pixel: local +x
    writeExr(folder / "sky.exr", image);
    LoadContext context;
    context.searchPaths = {folder};
    Builder b = emitter("envmap").with("filename", "sky.exr").with("scale", 2.0);
    const LightPtr sky = makeLight(*b.element, context);
    EXPECT_TRUE(sky->isEnvironment());
    EXPECT_NEAR(sky->environmentRadiance({1, 0, 0}).x, 8, 1e-3);
    EXPECT_NEAR(sky->environmentRadiance({-1, 0, 0}).x, 1, 1e-3);
    const Builder stretched =
        emitter("envmap").with("filename", "sky.exr").with("to_world", Transform::scale({1, 2, 1}));
    EXPECT_THAT(errorOf([&] { makeLight(*stretched.element, context); }), HasSubstr("scale uniformly"));
    EXPECT_THAT(errorOf([&] { makeLight(*emitter("envmap").with("filename", "none.exr").element, context); }),
                HasSubstr("none.exr"));
    std::filesystem::remove_all(folder);
}

TEST(EmitterPlugins, errorsNameThePlace) {
    EXPECT_THAT(errorOf([] { light(emitter("pont")); }), HasSubstr("scene.xml:7"));
    EXPECT_THAT(errorOf([] { light(emitter("pont")); }), HasSubstr("\"point\""));
    EXPECT_THAT(errorOf([] { light(emitter("area")); }), HasSubstr("nested in the shape"));
    EXPECT_THAT(errorOf([] { light(emitter("point").with("intensty", rgb(1, 1, 1))); }),
                HasSubstr("intensity"));
    EXPECT_THAT(errorOf([] { light(emitter("spot").with("cutoff_angle", 200.0)); }),
                HasSubstr("scene.xml:7"));
    EXPECT_THAT(errorOf([] { light(emitter("point").with("intensity", rgb(-1, 1, 1))); }),
                HasSubstr("scene.xml:"));
    LoadContext lenient;
    lenient.lenient = true;
    EXPECT_EQ(makeLight(*emitter("directionalarea").element, lenient), nullptr);
    EXPECT_EQ(lenient.warnings.size(), 1u);
}

TEST(EmitterPlugins, area) {
    const ShapePtr shape = makeRectangle(Transform(), false);
    LoadContext context;
    const LightPtr a =
        makeAreaLight(*emitter("area").with("radiance", rgb(1, 2, 3)).element, *shape, context);
    EXPECT_EQ(a->shape(), shape.get());
    EXPECT_NEAR(a->power(), luminance({1, 2, 3}) * kPi * 4, 1e-4);
    EXPECT_THAT(errorOf([&] { makeAreaLight(*emitter("point").element, *shape, context); }),
                HasSubstr("area"));
}

TEST(SensorPlugins, defaults) {
    const Sensor s = sensor(perspective());
    EXPECT_EQ(s.camera->window().fullWidth, 768);
    EXPECT_EQ(s.camera->window().height, 576);
    EXPECT_EQ(s.parts.filterKind, ReconstructionFilter::Kind::Gaussian);
    // 50 mm on 36 x 24 mm, about the diagonal.
    const Vec3f d = s.camera->sampleRay({}, {0, 0})->direction;
    EXPECT_NEAR(std::hypot(d.x, d.y) / d.z, std::hypot(36, 24) / 100, 1e-4);
    EXPECT_TRUE(s.context.warnings.empty());
}

TEST(SensorPlugins, filmAndFilter) {
    Builder filter("rfilter", "mitchell");
    filter.with("A", 0.2).with("B", 0.4);
    const Sensor s = sensor(perspective()
                                .with("fov", 90.0)
                                .containing(film()
                                                .with("width", 200)
                                                .with("height", 100)
                                                .with("crop_offset_x", 10)
                                                .with("crop_offset_y", 20)
                                                .with("crop_width", 30)
                                                .with("crop_height", 40)
                                                .with("pixel_format", "rgba")
                                                .containing(filter))
                                .containing(Builder("sampler", "independent").with("sample_count", 16)));
    const FilmWindow& w = s.camera->window();
    EXPECT_EQ(w.fullWidth, 200);
    EXPECT_EQ(w.x, 10);
    EXPECT_EQ(w.y, 20);
    EXPECT_EQ(w.width, 30);
    EXPECT_EQ(w.height, 40);
    EXPECT_EQ(s.parts.filterKind, ReconstructionFilter::Kind::Mitchell);
    EXPECT_FLOAT_EQ(s.parts.filter.b, 0.2f);
    EXPECT_FLOAT_EQ(s.parts.filter.c, 0.4f);
    ASSERT_EQ(s.context.warnings.size(), 1u);
    EXPECT_THAT(s.context.warnings[0], HasSubstr("rgba"));
}

TEST(SensorPlugins, commandLineOverridesTheFilm) {
    const auto scene = [] {
        return perspective().containing(film()
                                            .with("width", 200)
                                            .with("height", 100)
                                            .with("crop_offset_x", 50)
                                            .with("crop_offset_y", 20)
                                            .with("crop_width", 100)
                                            .with("crop_height", 60));
    };
    FilmOverride o;
    o.width = 100;
    o.height = 50;
    const FilmWindow scaled = sensor(scene(), o).camera->window();
    EXPECT_EQ(scaled.fullWidth, 100);
    EXPECT_EQ(scaled.x, 25);
    EXPECT_EQ(scaled.y, 10);
    EXPECT_EQ(scaled.width, 50);
    EXPECT_EQ(scaled.height, 30);
    o.hasCrop = true;
    o.cropX = 1;
    o.cropY = 2;
    o.cropWidth = 3;
    o.cropHeight = 4;
    const FilmWindow cropped = sensor(scene(), o).camera->window();
    EXPECT_EQ(cropped.x, 1);
    EXPECT_EQ(cropped.height, 4);
    o.cropWidth = 100;
    EXPECT_THAT(errorOf([&] { sensor(scene(), o); }), HasSubstr("not within the image of 100 x 50"));
}

TEST(SensorPlugins, badFilmsAndCameras) {
    const auto filmError = [](Builder b) { return errorOf([&] { sensor(perspective().containing(b)); }); };
    EXPECT_THAT(filmError(film().with("width", 0)), HasSubstr("scene.xml:7"));
    EXPECT_THAT(filmError(film().with("width", -3)), HasSubstr("-3"));
    EXPECT_THAT(filmError(film().with("width", 1 << 16).with("height", 1 << 16)), HasSubstr("too large"));
    EXPECT_THAT(filmError(film().with("crop_offset_x", 700).with("crop_width", 100)),
                HasSubstr("not within"));
    EXPECT_THAT(filmError(film().with("crop_offset_x", -1).with("crop_width", 100)), HasSubstr("not within"));
    EXPECT_THAT(filmError(film().with("pixel_format", "rgg")), HasSubstr("did you mean \"rgb\""));
    EXPECT_THAT(filmError(film().containing(Builder("rfilter", "gausian"))), HasSubstr("gaussian"));
    EXPECT_THAT(filmError(film().with("widht", 20)), HasSubstr("width"));
    const auto cameraError = [](Builder b) { return errorOf([&] { sensor(b); }); };
    EXPECT_THAT(cameraError(Builder("sensor", "perspektive")), HasSubstr("\"perspective\""));
    EXPECT_THAT(cameraError(perspective().with("fov", 180.0)), HasSubstr("fov"));
    EXPECT_THAT(cameraError(perspective().with("fov", 40.0).with("fov_axis", "z")), HasSubstr("diagonal"));
    EXPECT_THAT(cameraError(perspective().with("near_clip", 0.0)), HasSubstr("near_clip"));
    EXPECT_THAT(cameraError(perspective().with("to_world", Transform::scale({1, 2, 1}))),
                HasSubstr("to_world"));
    EXPECT_THAT(cameraError(Builder("sensor", "thinlens")), HasSubstr("aperture_radius"));
}

TEST(SensorPlugins, thinlensAndOrthographic) {
    const Sensor lens =
        sensor(Builder("sensor", "thinlens").with("aperture_radius", 0.5).with("focus_distance", 3.0));
    EXPECT_NEAR(lens.camera->sampleRay({}, {0, 0})->pdfPosition, 1 / (kPi * 0.25), 1e-5);
    EXPECT_FALSE(lens.camera->isInfinite());
    EXPECT_TRUE(sensor(Builder("sensor", "orthographic")).camera->isInfinite());
}

TEST(SensorPlugins, sphericalAndFisheye) {
    // 768 x 576; 0.6 documents the panorama with 2:1, but any film will do.
    const Sensor all = sensor(Builder("sensor", "spherical"));
    EXPECT_NEAR((all.camera->sampleRay({}, {576, 288})->direction - Vec3f(-1, 0, 0)).length(), 0, 1e-5);
    EXPECT_TRUE(all.camera->connect({0, 0, -1e-3f}, {})) << "no near clipping plane by default";
    EXPECT_FALSE(
        sensor(Builder("sensor", "spherical").with("near_clip", 0.1)).camera->connect({0, 0, -0.05f}, {}));
    for (const char* name : {"aperture", "fov"}) {
        const Sensor wide = sensor(Builder("sensor", "fisheye").with(name, 90.0));
        EXPECT_NEAR(wide.camera->sampleRay({}, {384, 1})->direction.y, std::sin(kPi / 4), 0.01);
    }
    const auto error = [](const Builder& b) { return errorOf([&] { sensor(b); }); };
    EXPECT_THAT(error(Builder("sensor", "fisheye").with("aperture", 400.0)), HasSubstr("(0, 360]"));
    EXPECT_THAT(error(Builder("sensor", "spherical").with("fov", 90.0)), HasSubstr("\"fov\""));
    EXPECT_THAT(error(Builder("sensor", "irradiancemeter")),
                HasSubstr("Mitsuba's sensor \"irradiancemeter\" is not supported; nearest: fisheye"));
    EXPECT_THAT(error(Builder("sensor", "telecentric")), HasSubstr("nearest: orthographic"));
}

}  // namespace
}  // namespace metrolux::core::mitsuba
