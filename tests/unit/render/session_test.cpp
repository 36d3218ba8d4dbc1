#include "render/session.h"

#include "base/error.h"
#include "fakes.h"
#include "render/threads.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

/// A square of 2x2 units with reflectance (0.2, 0.4, 0.6), 4 units in front of the camera, which sees beyond
/// its edges.
class Session : public testing::Test {
  protected:
    Session() : scene(std::make_shared<const Scene>(parts())) {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder =
            fs::path(testing::TempDir()) / fmt::format("metrolux-session-{}-{}", test->name(), ::getpid());
        fs::create_directories(folder);
        files.outputs = {folder / "a.exr", folder / "a.png"};
        files.limits.passes = 3;
        options.integrator = "fake";
        options.version = "1.2.3";
    }
    ~Session() override { fs::remove_all(folder); }

    static SceneParts parts() {
        SceneParts result;
        ShapePtr square = makeRectangle(Transform::rotate(Vec3f(0, 1, 0), 180), false);
        square->bsdf = std::make_shared<ColoredBsdf>();
        result.shapes.push_back(square);
        PerspectiveParameters camera;
        camera.toWorld = Transform::lookAt(Vec3f(0, 0, -4), Vec3f(0, 0, 0), Vec3f(0, 1, 0));
        camera.fov = 60;
        result.camera = makePerspectiveCamera(camera, {20, 10, 0, 0, 20, 10});
        result.filterKind = ReconstructionFilter::Kind::Box;
        result.source = "square.xml";
        return result;
    }
    SessionResult run(
        std::unique_ptr<Integrator> integrator = std::make_unique<test::FakeIntegrator>(),
        const std::function<bool()>& interrupted = [] { return false; }) {
        RenderSession session(scene, options, std::move(integrator));
        return session.run(files, {interrupted, {}, {}});
    }

    /// Absorbs everything but has a color.
    struct ColoredBsdf final : Bsdf {
        std::optional<BsdfSample> sample(const SurfaceInteraction&, const Vec3f&, TransportMode, float,
                                         const Vec2f&) const override {
            return std::nullopt;
        }
        BsdfEvaluation evaluate(const SurfaceInteraction&, const Vec3f&, const Vec3f&) const override {
            return {};
        }
        Rgb albedo(const SurfaceInteraction&) const override { return {0.2f, 0.4f, 0.6f}; }
        bool hasSmoothLobe() const override { return true; }
        bool hasDeltaLobe() const override { return false; }
    };
    std::shared_ptr<const Scene> scene;
    fs::path folder;
    SessionOptions options;
    RunOptions files;
};

TEST_F(Session, WritesImagesWithMetadata) {
    const SessionResult result = run();
    EXPECT_EQ(result.reason, StopReason::Passes);
    EXPECT_TRUE(result.written.failures.empty());
    const ImageData exr = readImage(folder / "a.exr", false), png = readImage(folder / "a.png", true);
    EXPECT_EQ(exr.width, 20);
    EXPECT_EQ(exr.height, 10);
    EXPECT_EQ(exr.at(3, 3)[0], 1);
    EXPECT_EQ(exr.at(3, 3)[2], 2);
    EXPECT_EQ(png.at(3, 3)[0], 1);
    EXPECT_EQ(png.at(3, 3)[1], 0);
    const Metadata metadata = readMetadata(folder / "a.exr");
    const auto has = [&](const char* name, const MetadataValue& value) {
        return std::find(metadata.begin(), metadata.end(),
                         std::pair<std::string, MetadataValue>(name, value)) != metadata.end();
    };
    EXPECT_TRUE(has("metrolux:integrator", "fake"));
    EXPECT_TRUE(has("metrolux:passes", 3));
    EXPECT_TRUE(has("metrolux:scene", "square.xml"));
    EXPECT_TRUE(has("metrolux:window", "20x10 at 0,0 of 20x10"));
    EXPECT_TRUE(has("Software", "Metrolux 1.2.3"));
}

TEST_F(Session, StatisticsHaveTheFields) {
    ThreadLimit threads(2);
    const nlohmann::json s = threads.execute([&] { return run(); }).statistics;
    for (const char* name : {"version", "scene", "integrator", "parameters", "seed", "threads", "passes",
                             "seconds", "relative_error", "rays", "peak_memory_bytes", "non_finite",
                             "integrator_statistics", "stop_reason"})
        EXPECT_TRUE(s.contains(name)) << name;
    EXPECT_EQ(s["threads"], 2);
    EXPECT_EQ(s["stop_reason"], "passes");
    EXPECT_TRUE(s["relative_error"].is_null());
    EXPECT_EQ(s["integrator_statistics"]["fake"], true);
    EXPECT_EQ(s["non_finite"]["merge"], 0);
    EXPECT_GT(s["peak_memory_bytes"], 1e6);
}

TEST_F(Session, AovsAreLayers) {
    options.aovs = {Aov::Albedo, Aov::Normal, Aov::Depth, Aov::Variance};
    run(std::make_unique<test::FakeIntegrator>([](uint32_t pass) { return static_cast<float>(pass); }));
    const auto value = [&](const char* layer, const char* channel, size_t pixel) {
        const ImageLayer l = readLayer(folder / "a.exr", layer);
        const auto c = static_cast<size_t>(std::find(l.channels.begin(), l.channels.end(), channel) -
                                           l.channels.begin());
        EXPECT_LT(c, l.channels.size());
        return l.pixels[pixel * l.channels.size() + c];
    };
    const size_t center = 5 * 20 + 10, corner = 0;
    EXPECT_FLOAT_EQ(value("albedo", "R", center), 0.2f);
    EXPECT_FLOAT_EQ(value("albedo", "B", center), 0.6f);
    EXPECT_EQ(value("albedo", "R", corner), 0);
    EXPECT_NEAR(value("normal", "Z", center), -1, 1e-5);
    EXPECT_NEAR(value("normal", "X", center), 0, 1e-5);
    EXPECT_NEAR(value("depth", "Z", center), 4, 0.05);
    EXPECT_EQ(value("depth", "Z", corner), 0);
    // Passes 0, 1, 2: variance of the mean 1/3 in units of the luminance of (1, 0, 2), squared.
    EXPECT_NEAR(value("variance", "Y", center), sqr(0.212671 + 2 * 0.072169) / 3, 1e-5);
    EXPECT_THROW(aovFromName("color"), Error);
}

TEST_F(Session, PlacesAndNumbersAreThoseOfTheMiddleOfAPixel) {
    SceneParts described = parts();
    described.shapes[0]->id = "square";
    described.shapes[0]->material = "paint";
    ShapePtr hidden = makeRectangle(Transform::translate(Vec3f(0, 0, 9)), false);
    hidden->bsdf = described.shapes[0]->bsdf;
    hidden->id = "hidden";
    hidden->material = "paint";
    described.shapes.insert(described.shapes.begin(), hidden);
    described.origin = {100, 0, 0};
    scene = std::make_shared<const Scene>(std::move(described));
    options.aovs = {Aov::Position, Aov::Uv, Aov::Object, Aov::Material, Aov::Motion};
    run();
    const auto values = [&](const char* layer, size_t pixel) {
        const ImageLayer l = readLayer(folder / "a.exr", layer);
        const size_t n = l.channels.size();
        return std::vector<float>(&l.pixels[pixel * n], &l.pixels[pixel * n] + n);
    };
    const size_t beside = 5 * 20 + 10, corner = 0;  // the middle of the image is where four pixels meet
    const float half = 4 * std::tan(30 * kPi / 180) / 20;
    const std::vector<float> position = values("position", beside), uv = values("uv", beside);
    EXPECT_NEAR(std::abs(position[0] - 100), half, 1e-4);
    EXPECT_NEAR(std::abs(position[1]), half, 1e-4);
    EXPECT_NEAR(position[2], 0, 1e-4);
    EXPECT_NEAR(std::abs(uv[0] - 0.5f), half / 2, 1e-4);
    EXPECT_EQ(values("object", beside), std::vector<float>{2});
    EXPECT_EQ(values("material", beside), std::vector<float>{1});
    EXPECT_EQ(values("motion", beside), (std::vector<float>{0, 0}));
    for (const char* layer : {"position", "uv", "object", "material"})
        EXPECT_THAT(values(layer, corner), testing::Each(0.0f)) << layer;
    const Metadata metadata = readMetadata(folder / "a.exr");
    using Attribute = std::pair<std::string, MetadataValue>;
    EXPECT_THAT(metadata, testing::Contains(Attribute("metrolux:objects", R"(["hidden","square"])")));
    EXPECT_THAT(metadata, testing::Contains(Attribute("metrolux:materials", R"(["paint"])")));
}

TEST_F(Session, RefusesOutputsBeforeRendering) {
    files.outputs = {folder / "absent" / "a.exr"};
    EXPECT_THROW(run(), Error);
    files.outputs = {folder / "a.jpg"};
    EXPECT_THROW(run(), Error);
    files.outputs = {folder / "a.exr", folder / "a.exr"};
    EXPECT_THROW(run(), Error);
    files.outputs = {folder / "A.EXR"};
    EXPECT_NO_THROW(run());
}

TEST_F(Session, InterruptedBeforeTheFirstPassWritesNothing) {
    const SessionResult result = run(std::make_unique<test::FakeIntegrator>(), [] { return true; });
    EXPECT_EQ(result.reason, StopReason::Interrupted);
    EXPECT_EQ(result.passes, 0u);
    EXPECT_TRUE(fs::is_empty(folder));
}

TEST_F(Session, SavesWhileItRenders) {
    files.saveEvery = 1e-9;
    files.limits.passes = 2;
    bool savedAfterFirstPass = false;
    run(std::make_unique<test::FakeIntegrator>([&](uint32_t pass) {
        if (pass == 1) savedAfterFirstPass = fs::exists(folder / "a.exr");
        return 1.0f;
    }));
    EXPECT_TRUE(savedAfterFirstPass);
}

TEST_F(Session, RescuesTheImageWhenItsFolderVanishes) {
    const fs::path before = fs::current_path();
    const fs::path gone = folder / "gone", elsewhere = folder / "elsewhere";
    fs::create_directories(gone);
    fs::create_directories(elsewhere);
    files.outputs = {gone / "a.exr"};
    fs::current_path(elsewhere);
    const SessionResult result = run(std::make_unique<test::FakeIntegrator>([&](uint32_t) {
        fs::remove_all(gone);
        return 1.0f;
    }));
    EXPECT_EQ(result.written.failures.size(), 1u);
    EXPECT_EQ(readImage(elsewhere / "metrolux-rescue-a.exr", false).width, 20);
    EXPECT_EQ(result.written.rescued.size(), 1u);
    fs::current_path(before);
}

}  // namespace
}  // namespace metrolux::core
