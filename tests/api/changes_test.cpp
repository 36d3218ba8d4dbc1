/// Scene::with() and what it is given: the result is what a fresh scene of the changed objects would be.

#include "support.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;

std::vector<float> twoPasses(const metrolux::Scene& scene) {
    metrolux::SessionOptions options;
    options.seed = 3;
    return rendered(scene, options, 2);
}

/// The ball of a file, with one text in place of another.
metrolux::Scene fromXml(const std::string& before = "", const std::string& after = "") {
    const TemporaryFolder folder;
    folder.write("floor.ply", kFloorPly);
    std::string xml = kBallXml;
    if (!before.empty()) xml.replace(xml.find(before), before.size(), after);
    return metrolux::Scene::load(folder.write("ball.xml", xml));
}

TEST(ApiChanges, AValueOfAMaterialChangesForAllWhoReferToIt) {
    const metrolux::Scene scene = metrolux::Scene::make(ball());
    const std::vector<float> before = twoPasses(scene);
    const Color red{0.6, 0.1, 0.1};
    const metrolux::Scene changed = scene.with({{"gray.reflectance", red}});
    EXPECT_EQ(
        twoPasses(changed),
        twoPasses(metrolux::Scene::make(ball().set("gray", Object("diffuse", {{"reflectance", red}})))));
    EXPECT_NE(twoPasses(changed), before);
    EXPECT_EQ(twoPasses(scene), before) << "a scene never changes";
    EXPECT_EQ(twoPasses(scene.with({{"floor.bsdf.reflectance", red}})), twoPasses(changed))
        << "the other path to it";
    EXPECT_EQ(twoPasses(changed.with({{"gray.reflectance", Vector{0.5, 0.4, 0.3}}})), before)
        << "three numbers in place of a color";
}

TEST(ApiChanges, AnObjectTakesThePlaceOfAnother) {
    const metrolux::Scene scene = metrolux::Scene::make(ball());
    const Object metal("conductor", {{"material", "Au"}});
    EXPECT_EQ(twoPasses(scene.with({{"gray", metal}})),
              twoPasses(metrolux::Scene::make(ball().set("gray", metal))));
    Object floor = *std::get<std::shared_ptr<const Object>>(ball().find("floor")->data());
    const std::vector<float> own =
        twoPasses(metrolux::Scene::make(ball().set("floor", floor.set("bsdf", metal))));
    EXPECT_EQ(twoPasses(scene.with({{"floor.bsdf", Reference{"gray"}}})), twoPasses(scene));
    EXPECT_EQ(twoPasses(scene.with({{"gold", metal}, {"floor.bsdf", Reference{"gold"}}})), own)
        << "a new object, and a reference to it";
    EXPECT_EQ(twoPasses(scene.with({{"ball.radius", 0.3}, {"lamp.light.radiance", 4.0}})),
              twoPasses(scene.with({{"lamp.light.radiance", 4.0}, {"ball.radius", 0.3}})));
}

TEST(ApiChanges, ArraysOfAMeshCanChange) {
    Mesh lifted = *std::get<std::shared_ptr<const Mesh>>(
        std::get<std::shared_ptr<const Object>>(ball().find("floor")->data())->find("arrays")->data());
    for (size_t i = 2; i < lifted.positions.size(); i += 3) lifted.positions[i] = 0.1f;
    Object floor = *std::get<std::shared_ptr<const Object>>(ball().find("floor")->data());
    EXPECT_EQ(twoPasses(metrolux::Scene::make(ball()).with({{"floor.arrays", lifted}})),
              twoPasses(metrolux::Scene::make(ball().set("floor", floor.set("arrays", lifted)))));
}

TEST(ApiChanges, TheSensorAloneLeavesTheGeometryWhereItIs) {
    const metrolux::Scene scene = metrolux::Scene::make(ball());
    const metrolux::Scene wide = scene.with({{"camera.fov", 70.0}, {"camera.film.width", 32}});
    EXPECT_TRUE(wide.sharesGeometryWith(scene));
    EXPECT_EQ(wide.resolution().width, 32);
    Object camera = *std::get<std::shared_ptr<const Object>>(ball().find("camera")->data());
    Object film = *std::get<std::shared_ptr<const Object>>(camera.find("film")->data());
    camera.set("fov", 70.0).set("film", film.set("width", 32));
    EXPECT_EQ(twoPasses(wide), twoPasses(metrolux::Scene::make(ball().set("camera", camera))));
    EXPECT_FALSE(scene.with({{"ball.radius", 0.5}}).sharesGeometryWith(scene));
}

TEST(ApiChanges, WhatWasChangedBeforeStays) {
    const auto place = metrolux::Transform::lookAt({1, 3, 5}, {0, 0, 0}, {0, 1, 0});
    metrolux::FilmChange film;
    film.resolution = metrolux::Resolution{20, 10};
    metrolux::PathChange paths;
    paths.maxDepth = 3;
    const Object::Values red{{"gray.reflectance", Color{0.6, 0.1, 0.1}}};
    const metrolux::Scene scene = metrolux::Scene::make(ball());
    EXPECT_EQ(twoPasses(scene.withCamera(place).withFilm(film).withPaths(paths).with(red)),
              twoPasses(scene.with(red).withCamera(place).withFilm(film).withPaths(paths)));
    EXPECT_EQ(twoPasses(scene.with({{"camera.fov", 60.0}}).with(red)),
              twoPasses(scene.with(red).with({{"camera.fov", 60.0}})));
    EXPECT_EQ(scene.withFilm(film).with({{"camera.film.height", 12}}).resolution().width, 24)
        << "the film's own values hold again";
}

TEST(ApiChanges, FilesHavePathsToo) {
    const TemporaryFolder folder;
    folder.write("floor.ply", kFloorPly);
    const metrolux::Scene scene = metrolux::Scene::load(folder.write("ball.xml", kBallXml));
    const metrolux::Scene changed = scene.with({{"gray.reflectance", Color{0.25, 0.5, 0.125}}});
    EXPECT_EQ(twoPasses(changed), twoPasses(fromXml("0.5, 0.4, 0.3", "0.25, 0.5, 0.125")));
    EXPECT_EQ(changed.source(), scene.source());
    EXPECT_EQ(twoPasses(scene.with({{"shape_3.emitter.radiance", Color{1, 2, 3}}})),
              twoPasses(fromXml("10, 9, 8", "1, 2, 3")));
    EXPECT_EQ(twoPasses(scene.with({{"shape_2.bsdf.int_ior", 1.25}})),
              twoPasses(fromXml("int_ior\" value=\"1.5", "int_ior\" value=\"1.25")));
}

TEST(ApiChanges, ValuesAreListedByTheirPaths) {
    const auto pathsOf = [](const metrolux::Scene& scene) {
        std::vector<std::string> paths;
        for (const auto& [path, value] : scene.values()) paths.push_back(path);
        return paths;
    };
    const metrolux::Scene code = metrolux::Scene::make(ball());
    EXPECT_THAT(pathsOf(code), testing::ElementsAre("integrator.max_depth", "camera.fov", "camera.to_world",
                                                    "camera.film.width", "camera.film.height",
                                                    "gray.reflectance", "floor.arrays", "floor.to_world",
                                                    "ball.center", "ball.radius", "ball.glass.int_ior",
                                                    "lamp.to_world", "lamp.light.radiance", "sky.radiance"));
    const metrolux::Scene file = fromXml();
    EXPECT_THAT(pathsOf(file), testing::IsSupersetOf({"sensor.fov", "gray.reflectance", "shape.filename",
                                                      "shape_2.bsdf.int_ior", "shape_3.emitter.radiance"}));
    const Object::Values values = code.with({{"camera.fov", 70.0}}).values();
    EXPECT_EQ(std::get<double>(values[1].second.data()), 70);
    EXPECT_EQ(std::get<Color>(values[5].second.data()).g, static_cast<double>(0.4f));
    EXPECT_EQ(twoPasses(code.with(values)), twoPasses(code.with({{"camera.fov", 70.0}})))
        << "each of them may be set";
}

TEST(ApiChanges, AMapThatFlattensIsNotListed) {
    const TemporaryFolder folder;
    folder.write("floor.ply", kFloorPly);
    std::string xml = kBallXml;
    const std::string scale = "<scale value=\"3\"/>";
    xml.replace(xml.find(scale), scale.size(), "<scale x=\"3\" y=\"3\" z=\"0\"/>");
    const metrolux::Scene scene = metrolux::Scene::load(folder.write("ball.xml", xml));
    std::vector<std::string> paths;
    for (const auto& [path, value] : scene.values()) paths.push_back(path);
    EXPECT_THAT(paths, testing::Contains("shape_3.to_world"));
    EXPECT_THAT(paths, testing::Not(testing::Contains("shape.to_world")));
    EXPECT_EQ(twoPasses(scene.with(scene.values())), twoPasses(scene));
}

TEST(ApiChanges, ErrorsNameThePath) {
    const metrolux::Scene scene = metrolux::Scene::make(ball());
    const auto errorWith = [&](const char* path, const Value& value) {
        return errorOf([&] { scene.with({{path, value}}); });
    };
    EXPECT_THAT(errorWith("gary.reflectance", 0.5),
                HasSubstr("scene: found the path \"gary.reflectance\", and nothing with the name \"gary\"; "
                          "did you mean \"gray\"?"));
    EXPECT_THAT(errorWith("gray.reflectance.x", 0.5), HasSubstr("nothing is inside of \"reflectance\""));
    EXPECT_THAT(errorWith("gray.reflectence", 0.5), HasSubstr("did you mean \"reflectance\"?"));
    EXPECT_THAT(errorWith("gray", 0.5), HasSubstr("scene:gray: found a value, expected an object"));
    EXPECT_THAT(errorWith("ball.radius", "wide"), HasSubstr("scene:ball.radius:"));
    EXPECT_THAT(errorWith("floor.bsdf", Reference{"grey"}), HasSubstr("did you mean \"gray\"?"));
    EXPECT_THAT(errorWith("ball", Object("spere")),
                HasSubstr("unknown shape type; did you mean \"sphere\"?"));
    EXPECT_THAT(errorWith("", 0.5), HasSubstr("nothing with the name \"\""));
}

TEST(ApiChanges, ACheckpointIsOfTheChangedScene) {
    const TemporaryFolder folder;
    const metrolux::Scene scene = metrolux::Scene::make(ball());
    metrolux::Session session(scene.with({{"gray.reflectance", 0.5}}), {});
    session.step();
    session.save(folder.path() / "a");
    EXPECT_THAT(errorOf([&] { metrolux::Session(scene, {}).resume(folder.path() / "a"); }),
                HasSubstr("/scene/content"));
    EXPECT_EQ(errorOf([&] {
                  metrolux::Session(scene.with({{"gray.reflectance", 0.5}}), {}).resume(folder.path() / "a");
              }),
              "nothing was thrown");
}

}  // namespace
}  // namespace metrolux::core::test
