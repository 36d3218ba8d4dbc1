#include "support.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;

metrolux::Scene fromXml(const metrolux::LoadOptions& options = {}) {
    const TemporaryFolder folder;
    folder.write("floor.ply", kFloorPly);
    return metrolux::Scene::load(folder.write("ball.xml", kBallXml), options);
}

metrolux::SessionOptions mcmc() {
    metrolux::SessionOptions options;
    options.seed = 3;
    return options;
}

TEST(ApiScene, CodeAndFileGiveTheSameBits) {
    const metrolux::Scene code = metrolux::Scene::make(ball()), file = fromXml();
    EXPECT_THAT(code.warnings(), testing::IsEmpty());
    EXPECT_EQ(code.sizes().primitives, file.sizes().primitives);
    EXPECT_EQ(code.integrator(), "path");
    EXPECT_EQ(rendered(code, mcmc(), 4), rendered(file, mcmc(), 4));
}

TEST(ApiScene, SmallObjectsOfLoadDictAreValues) {
    Object scene = ball();
    scene.set("gray",
              Object("diffuse", {{"reflectance", Object("rgb", {{"value", Vector{0.5, 0.4, 0.3}}})}}));
    scene.set("floor", Object(*std::get<std::shared_ptr<const Object>>(scene.find("floor")->data()))
                           .set("bsdf", Object("ref", {{"id", "gray"}})));
    EXPECT_EQ(rendered(metrolux::Scene::make(scene), mcmc(), 1), rendered(fromXml(), mcmc(), 1));
}

TEST(ApiScene, PixelsStandForFiles) {
    const TemporaryFolder folder;
    const Image image{{0.1f, 0.2f, 0.3f, 0.9f, 0.8f, 0.7f, 0.5f, 0.1f, 0.2f, 0.3f, 0.6f, 0.4f}, 2, 2, 3};
    writeImage(folder.path() / "a.exr", image.view());
    const auto with = [&](const char* name, const Value& value) {
        Object scene = ball();
        scene.set("gray", Object("diffuse", {{"reflectance", Object("bitmap", {{name, value}})}}));
        return scene.set("sky", Object("envmap", {{name, value}}));
    };
    const metrolux::Scene pixels = metrolux::Scene::make(with("data", image));
    EXPECT_EQ(rendered(pixels, mcmc(), 2),
              rendered(metrolux::Scene::make(with("filename", "a.exr"), {}, folder.path()), mcmc(), 2));
    EXPECT_EQ(rendered(pixels.with(pixels.values()), mcmc(), 2), rendered(pixels, mcmc(), 2));
    EXPECT_THAT(errorOf([&] {
                    metrolux::Scene::make(with("data", Image{{1, 2}, 1, 1, 3}));
                }),
                HasSubstr("found 2 numbers for 1x1 pixels of 3 channels"));
    EXPECT_THAT(errorOf([&] { metrolux::Scene::make(with("data", "a.exr")); }),
                testing::AllOf(testing::StartsWith("scene:sky.data: <emitter type=\"envmap\">: property"),
                               HasSubstr("expected the pixels of an image")));
    EXPECT_THAT(
        errorOf([&] {
            metrolux::Scene::make(ball()).with({{"gray.reflectance", Object("bitmap")}});
        }),
        testing::StartsWith("scene:gray.reflectance: <texture type=\"bitmap\">: has no \"filename\""));
    EXPECT_THAT(errorOf([&] { metrolux::Scene::make(with("fle", image)); }), HasSubstr("no \"filename\""));
}

TEST(ApiScene, FarFromTheOriginCamerasAreWhereTheirCoordinatesSay) {
    // As ball(), far away: all that has a place is moved there.
    const metrolux::Transform there = metrolux::Transform::translate({2e6, 0, -1e6});
    const auto object = [](const Object& scene, const char* name) {
        return *std::get<std::shared_ptr<const Object>>(scene.find(name)->data());
    };
    Object far = ball();
    for (const char* name : {"camera", "floor", "lamp"}) {
        Object part = object(far, name);
        const auto own = std::get<metrolux::Transform>(part.find("to_world")->data());
        far.set(name, part.set("to_world", there * own));
    }
    far.set("ball", object(far, "ball").set("center", Vector{2e6, 0.7, -1e6}));
    const metrolux::Scene scene = metrolux::Scene::make(far);
    const auto place = metrolux::Transform::lookAt({2e6 + 1, 2, -1e6 + 4}, {2e6, 0.5, -1e6}, {0, 1, 0});
    const metrolux::Scene moved = scene.withCamera(place);
    EXPECT_TRUE(moved.sharesGeometryWith(scene));
    Object fresh = far;
    fresh.set("camera", object(far, "camera").set("to_world", place));
    const std::vector<float> image = rendered(moved, mcmc(), 4);
    EXPECT_EQ(image, rendered(metrolux::Scene::make(fresh), mcmc(), 4));
    Object near = ball();
    near.set("camera", object(near, "camera")
                           .set("to_world", metrolux::Transform::lookAt({1, 2, 4}, {0, 0.5, 0}, {0, 1, 0})));
    double difference = 0, sum = 0;
    const std::vector<float> reference = rendered(metrolux::Scene::make(near), mcmc(), 4);
    for (size_t i = 0; i < image.size(); ++i) {
        difference += double(image[i]) - double(reference[i]);
        sum += double(reference[i]);
    }
    EXPECT_LT(std::abs(difference), 0.1 * sum);
}

TEST(ApiScene, ChangesOfTheViewShareTheGeometryAndEqualAFreshScene) {
    const metrolux::Scene scene = metrolux::Scene::make(ball());
    // Far outside: the infinite light's disk grows with the bounds, and that of `scene` may not.
    const auto place = metrolux::Transform::lookAt({0, 3, 40}, {0, 0, 0}, {0, 1, 0});
    const std::vector<float> before = rendered(scene, mcmc(), 2);
    const metrolux::Scene moved = scene.withCamera(place);
    EXPECT_TRUE(moved.sharesGeometryWith(scene));
    Object fresh = ball();
    Object camera = *std::get<std::shared_ptr<const Object>>(fresh.find("camera")->data());
    fresh.set("camera", camera.set("to_world", place));
    EXPECT_EQ(rendered(moved, mcmc(), 2), rendered(metrolux::Scene::make(fresh), mcmc(), 2));
    EXPECT_EQ(rendered(scene, mcmc(), 2), before);

    metrolux::FilmChange film;
    film.resolution = metrolux::Resolution{40, 30};
    film.crop = metrolux::Crop{4, 5, 20, 10};
    film.filter = "box";
    metrolux::LoadOptions options;
    options.film = film;
    const metrolux::Scene cropped = scene.withFilm(film);
    EXPECT_TRUE(cropped.sharesGeometryWith(scene));
    EXPECT_EQ(cropped.window().width, 20);
    EXPECT_EQ(rendered(cropped, mcmc(), 2), rendered(metrolux::Scene::make(ball(), options), mcmc(), 2));

    metrolux::PathChange paths;
    paths.maxDepth = 2;
    metrolux::SessionOptions direct = mcmc();
    direct.maxDepth = 2;
    EXPECT_EQ(rendered(scene.withPaths(paths), mcmc(), 2), rendered(scene, direct, 2));
}

TEST(ApiScene, AnotherSensorKeepsTheFilmUnlessItBringsOne) {
    metrolux::FilmChange film;
    film.resolution = metrolux::Resolution{40, 30};
    const metrolux::Scene scene = metrolux::Scene::make(ball()).withFilm(film);
    const Object bare("orthographic",
                      {{"to_world", metrolux::Transform::lookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0})}});
    EXPECT_EQ(scene.withCamera(bare).resolution().width, 40);
    Object own = bare;
    own.set("film", Object("hdrfilm", {{"width", 8}, {"height", 6}}));
    EXPECT_EQ(scene.withCamera(own).resolution().width, 8);
    EXPECT_EQ(rendered(scene.withCamera(own), mcmc(), 1).size(), 3u * 8 * 6);
}

TEST(ApiScene, LivesAsLongAsASessionNeedsIt) {
    auto scene = std::make_unique<metrolux::Scene>(metrolux::Scene::make(ball()));
    metrolux::Session session(*scene, mcmc());
    scene.reset();
    session.step();
    EXPECT_EQ(session.progress().passes, 1u);
}

TEST(ApiScene, ErrorsSayWhereInTheTree) {
    const auto errorWith = [](const char* name, const Value& value) {
        return errorOf([&] { metrolux::Scene::make(ball().set(name, value)); });
    };
    EXPECT_THAT(errorWith("ball", Object("sphere", {{"radus", 0.7}})),
                HasSubstr("scene:ball.radus: <shape type=\"sphere\">"));
    EXPECT_THAT(errorWith("ball", Object("sphere", {{"radus", 0.7}})), HasSubstr("did you mean \"radius\"?"));
    EXPECT_THAT(errorWith("ball", Object("spere")),
                HasSubstr("scene:ball: unknown type \"spere\"; did you mean \"sphere\"?"));
    EXPECT_THAT(errorWith("ball", Object("sphere", {{"radius", "wide"}})), HasSubstr("expected a <float>"));
    EXPECT_THAT(errorWith("ball", Object("sphere", {{"radius", std::nan("")}})),
                HasSubstr("scene:ball.radius: found nan, expected a finite number"));
    EXPECT_THAT(errorWith("ball", Object("sphere", {{"bsdf", Reference{"grey"}}})),
                HasSubstr("did you mean \"gray\"?"));
    EXPECT_THAT(errorWith("camera", 3.0), HasSubstr("no <sensor>"));
    Mesh open;
    open.positions = {0, 0, 0, 1, 0, 0};
    open.triangles = {0, 1, 2};
    EXPECT_THAT(
        errorWith("ball", Object("mesh", {{"arrays", open}})),
        HasSubstr("scene:ball: <shape type=\"mesh\" id=\"ball\">: arrays: a face refers to vertex 2"));
    open.positions.pop_back();
    EXPECT_THAT(errorWith("ball", Object("mesh", {{"arrays", open}})),
                HasSubstr("found 5 numbers in \"positions\""));
    EXPECT_THAT(errorOf([] { metrolux::Scene::make(Object("sphere")); }), HasSubstr("expected \"scene\""));
    EXPECT_THAT(errorOf([] { metrolux::Scene::load("absent.xml"); }),
                HasSubstr("absent.xml: the file does not exist"));
    EXPECT_THAT(errorOf([] {
                    metrolux::FilmChange change;
                    change.resolution = metrolux::Resolution{0, 4};
                    metrolux::Scene::make(ball()).withFilm(change);
                }),
                HasSubstr("resolution 0x4: both sides"));
}

TEST(ApiScene, WarningsGoToTheReceiver) {
    std::vector<std::string> received;
    setLog([&](LogLevel level, const std::string& message) {
        if (level == LogLevel::Warning) received.push_back(message);
    });
    metrolux::LoadOptions lenient;
    lenient.lenient = true;
    const metrolux::Scene scene =
        metrolux::Scene::make(ball().set("ball", Object("sphere", {{"radus", 0.7}})), lenient);
    setLog({});
    EXPECT_THAT(received, testing::ElementsAre(HasSubstr("radus")));
    EXPECT_EQ(scene.warnings(), received);
}

}  // namespace
}  // namespace metrolux::core::test
