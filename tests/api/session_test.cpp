#include "paths.h"
#include "support.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace metrolux::core::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ApiSession : public testing::Test {
  protected:
    ApiSession() { options.seed = 5; }
    static metrolux::Limits passes(std::uint32_t count) {
        metrolux::Limits limits;
        limits.passes = count;
        return limits;
    }
    /// Runs the command in the folder; true if it ends well.
    bool command(const std::string& words) const {
        const std::string line = "cd " + folder.path().string() + " && " + METROLUX_BINARY_DIR "/metrolux " +
                                 words + " --quiet > out.txt 2>&1";
        return std::system(line.c_str()) == 0;
    }
    TemporaryFolder folder;
    metrolux::Scene scene = metrolux::Scene::make(ball());
    metrolux::SessionOptions options;
};

TEST_F(ApiSession, HasTheSameBitsAsTheCommand) {
    folder.write("floor.ply", kFloorPly);
    const fs::path file = folder.write("ball.xml", kBallXml);
    const metrolux::Scene loaded = metrolux::Scene::load(file);
    for (const std::string integrator : {"path", "vcm", "mcmc_vcm"}) {
        ASSERT_TRUE(
            command("render ball.xml -i " + integrator + " --passes 4 --seed 5 --max-depth 5 -o a.exr"));
        options.integrator = integrator;
        options.maxDepth = 5;
        metrolux::Session session(loaded, options);
        session.render(passes(4));
        EXPECT_EQ(pixels(session.image()), metrolux::readImage(folder.path() / "a.exr").pixels) << integrator;
    }
}

TEST_F(ApiSession, StepsAndARunAreTheSame) {
    metrolux::Session steps(scene, options), run(scene, options);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(steps.step().passes, static_cast<std::uint32_t>(i + 1));
    const metrolux::Outcome first = run.render(passes(2)), second = run.render(passes(5));
    EXPECT_EQ(first.passes, 2u);
    EXPECT_EQ(second.reason, metrolux::StopReason::Passes);
    EXPECT_EQ(second.passes, 5u);
    EXPECT_EQ(pixels(steps.image()), pixels(run.image()));
    EXPECT_GT(steps.progress().seconds, 0);
    EXPECT_GT(steps.progress().raysPerSecond, 0);
    EXPECT_THAT(steps.statistics(), HasSubstr("\"stop_reason\": null"));
    EXPECT_THAT(run.statistics(), HasSubstr("\"stop_reason\": \"passes\""));
}

TEST_F(ApiSession, ViewsStayWhereTheyAre) {
    options.layers = {"albedo", "depth", "variance", "denoised"};
    metrolux::Session session(scene, options);
    session.step();
    session.step();
    const ImageView denoised = session.layer("denoised");
    EXPECT_NE(pixels(denoised), pixels(session.image()));
    const ImageView image = session.image(), variance = session.variance(), albedo = session.layer("albedo");
    const std::vector<float> before = pixels(image);
    EXPECT_EQ(albedo.channels, 3);
    EXPECT_EQ(session.layer("depth").channels, 1);
    EXPECT_EQ(session.layer("variance").data, variance.data);
    session.step();
    EXPECT_EQ(session.image().data, image.data);
    EXPECT_EQ(session.variance().data, variance.data);
    EXPECT_EQ(session.layer("albedo").data, albedo.data);
    EXPECT_EQ(session.layer("denoised").data, denoised.data);
    EXPECT_NE(pixels(image), before);
    EXPECT_THAT(errorOf([&] { session.layer("normal"); }), HasSubstr("albedo, depth, variance"));

    metrolux::Session moved = std::move(session);
    EXPECT_EQ(moved.image().data, image.data);
}

TEST_F(ApiSession, LeavesItsBuffers) {
    options.layers = {"albedo", "depth", "variance", "denoised"};
    metrolux::Session session(scene, options), same(scene, options);
    session.render(passes(2));
    same.render(passes(2));
    const float* const image = session.image().data;
    const float* const albedo = session.layer("albedo").data;
    const metrolux::Picture picture = std::move(session).finish();
    EXPECT_EQ(picture.image.pixels.data(), image);
    EXPECT_EQ(picture.layers.at("albedo").pixels.data(), albedo);
    EXPECT_EQ(picture.image.pixels, pixels(same.image()));
    for (const std::string& name : options.layers) {
        EXPECT_EQ(picture.layers.at(name).pixels, pixels(same.layer(name))) << name;
        EXPECT_EQ(picture.layers.at(name).channels, same.layer(name).channels) << name;
    }
}

TEST_F(ApiSession, StopsWhenAnotherThreadAsks) {
    metrolux::Session session(scene, options);
    std::atomic<bool> begun{false};
    metrolux::Hooks hooks;
    hooks.progress = [&](const metrolux::Progress&) { begun = true; };
    std::thread other([&] {
        while (!begun) std::this_thread::yield();
        session.requestStop();
    });
    metrolux::Limits limits;
    limits.seconds = 100;
    const metrolux::Outcome outcome = session.render(limits, hooks);
    other.join();
    EXPECT_EQ(outcome.reason, metrolux::StopReason::Interrupted);
    EXPECT_GE(outcome.passes, 1u);
    EXPECT_LT(session.progress().seconds, 60);
    EXPECT_EQ(session.render(passes(outcome.passes + 1)).passes, outcome.passes + 1)
        << "one request is one stop";
}

TEST_F(ApiSession, ResumesBitForBit) {
    const fs::path file = folder.path() / "a.checkpoint";
    for (const std::string integrator : {"path", "mcmc_vcm", "pssmlt"}) {
        options.integrator = integrator;
        metrolux::Session whole(scene, options), part(scene, options), rest(scene, options);
        whole.render(passes(6));
        part.render(passes(3));
        part.save(file);
        rest.resume(file);
        EXPECT_EQ(rest.progress().passes, 3u);
        rest.step();
        rest.render(passes(6));
        EXPECT_EQ(pixels(rest.image()), pixels(whole.image())) << integrator;
    }
}

TEST_F(ApiSession, RefusesCheckpointsOfOtherRenderings) {
    const fs::path file = folder.path() / "a.checkpoint";
    metrolux::Session session(scene, options);
    session.step();
    session.save(file);
    EXPECT_THAT(errorOf([&] { session.resume(file); }), HasSubstr("has 1 passes, expected none"));
    const auto refused = [&](const metrolux::Scene& other, const metrolux::SessionOptions& o) {
        return errorOf([&] { metrolux::Session(other, o).resume(file); });
    };
    metrolux::SessionOptions seed = options;
    seed.seed = 6;
    EXPECT_THAT(refused(scene, seed), HasSubstr("/algorithm/seed: found 6, expected 5"));
    Object changed = ball();
    changed.set("gray", Object("diffuse", {{"reflectance", Color{0.5, 0.4, 0.31}}}));
    EXPECT_THAT(refused(metrolux::Scene::make(changed), options), HasSubstr("/scene/content"));
    const auto place = metrolux::Transform::lookAt({0, 2, 7}, {0, 0.5, 0}, {0, 1, 0});
    EXPECT_THAT(refused(scene.withCamera(place), options), HasSubstr("/scene/camera"));
    EXPECT_EQ(refused(metrolux::Scene::make(ball()), options), "nothing was thrown");
}

TEST_F(ApiSession, GoesOnFromTheCommandsCheckpointAndTheCommandFromIts) {
    folder.write("floor.ply", kFloorPly);
    const fs::path xml = folder.write("ball.xml", kBallXml);
    ASSERT_TRUE(command("render ball.xml --passes 2 --seed 5 --checkpoint a.checkpoint"));
    metrolux::Session session(metrolux::Scene::load(xml), options);
    session.resume(folder.path() / "a.checkpoint");
    metrolux::Files files;
    files.checkpoint = folder.path() / "b.checkpoint";
    files.command = {"metrolux", "render", xml.string(), "--seed", "5", "-o", "b.exr"};
    session.render(passes(4), {}, files);
    ASSERT_TRUE(command("resume b.checkpoint --passes 6 -o b.exr"));
    EXPECT_EQ(metrolux::readImage(folder.path() / "b.exr").pixels,
              rendered(metrolux::Scene::load(xml), options, 6));
}

TEST_F(ApiSession, WritesFiles) {
    metrolux::Files files;
    files.images = {folder.path() / "a.exr", folder.path() / "a.png"};
    files.display.exposure = 1;
    options.layers = {"normal"};
    metrolux::Session session(scene, options);
    const metrolux::Outcome outcome = session.render(passes(2), {}, files);
    EXPECT_THAT(outcome.failures, testing::IsEmpty());
    EXPECT_EQ(metrolux::readImage(files.images[0]).pixels, pixels(session.image()));
    session.saveImage(folder.path() / "b.png", files.display);
    EXPECT_EQ(metrolux::readImage(folder.path() / "b.png").pixels,
              metrolux::readImage(files.images[1]).pixels);
    EXPECT_EQ(displayImage(session.image(), files.display).size(), 3u * 24 * 16);
    EXPECT_THAT(errorOf([&] { session.saveImage(folder.path() / "b.jpg"); }),
                HasSubstr("expected .exr or .png"));
    files.images = {folder.path() / "absent" / "a.exr"};
    EXPECT_THAT(errorOf([&] { session.render(passes(4), {}, files); }), HasSubstr("absent"));
    EXPECT_EQ(session.progress().passes, 2u);
}

TEST_F(ApiSession, NoOutputReplacesWhatIsRead) {
    const fs::path mesh = folder.write("floor.ply", kFloorPly), file = folder.write("c.1", kBallXml);
    const auto contentOf = [](const fs::path& path) {
        std::ifstream stream(path, std::ios::binary);
        return std::string((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    };
    fs::create_symlink(mesh, folder.path() / "alias.exr");
    metrolux::Session session(metrolux::Scene::load(file), options);
    session.step();
    EXPECT_THAT(errorOf([&] { session.save(mesh); }), HasSubstr("would replace"));
    EXPECT_THAT(errorOf([&] { session.saveImage(folder.path() / "alias.exr"); }), HasSubstr("would replace"));
    metrolux::Files files;
    files.checkpoint = folder.path() / "c";  // the one before the last would be c.1
    EXPECT_THAT(errorOf([&] { session.render(passes(3), {}, files); }), HasSubstr("would replace"));
    EXPECT_THAT(errorOf([&] { session.save(files.checkpoint); }), HasSubstr("would replace"));
    EXPECT_EQ(contentOf(mesh), kFloorPly);
    EXPECT_EQ(contentOf(file), kBallXml);

    const fs::path part = folder.path() / "part.exr";
    session.save(part);
    files = {};
    files.images = {part};
    files.overwrite = true;
    EXPECT_THAT(errorOf([&] { metrolux::merge({part}, files); }), HasSubstr("would replace"));
}

/// A checkpoint names the files from which the scene was made, not those that have their names by now.
TEST_F(ApiSession, FilesThatHaveChangedSinceTheyWereReadAreInNoCheckpoint) {
    folder.write("scene.xml", core::test::kBallXml);
    folder.write("floor.ply", core::test::kFloorPly);
    const fs::path file = folder.path() / "scene.xml", saved = folder.path() / "saved";
    const auto saving = [&](const metrolux::Scene& made) {
        metrolux::Session session(made, options);
        session.step();
        return errorOf([&] { session.save(saved); });
    };
    const std::string nothing = errorOf([] {});
    // Later than the clock, as from an archive or another machine: that is no sign of a change.
    fs::last_write_time(file, fs::file_time_type::clock::now() + std::chrono::hours(5));
    const metrolux::Scene loaded = metrolux::Scene::load(file);
    EXPECT_EQ(saving(loaded), nothing);
    folder.write("floor.ply", std::string(core::test::kFloorPly) + "\n");
    EXPECT_THAT(saving(loaded), HasSubstr("floor.ply: has changed since it was read"));
    // What is read within a tick of the file system's clock after it was written might have changed after.
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_EQ(saving(metrolux::Scene::load(file)), nothing);
    fs::remove(folder.path() / "floor.ply");
    EXPECT_NE(saving(loaded), nothing);
}

TEST_F(ApiSession, SlicesThatAreMergedAreOneRendering) {
    options.slices.count = 4;
    metrolux::Session whole(scene, options);
    whole.render(passes(8));
    std::vector<fs::path> parts;
    for (std::uint32_t half : {0u, 2u}) {
        metrolux::SessionOptions own = options;
        own.slices.first = half;
        own.slices.last = half + 1;
        metrolux::Session session(scene, own);
        session.render(passes(8));
        parts.push_back(folder.path() / ("part" + std::to_string(half)));
        session.save(parts.back());
    }
    metrolux::Files files;
    files.images = {folder.path() / "merged.exr"};
    const metrolux::Merged merged = metrolux::merge(parts, files);
    EXPECT_EQ(merged.outcome.passes, 8u);
    EXPECT_EQ(metrolux::readImage(files.images[0]).pixels, pixels(whole.image()));
}

TEST_F(ApiSession, ErrorsHaveTheCommandsText) {
    const auto errorWith = [&](const std::function<void(metrolux::SessionOptions&)>& change) {
        metrolux::SessionOptions wrong = options;
        change(wrong);
        return errorOf([&] { metrolux::Session(scene, wrong); });
    };
    EXPECT_THAT(errorWith([](auto& o) { o.integrator = "mcmc_vmc"; }),
                HasSubstr("unknown integrator 'mcmc_vmc', did you mean 'mcmc_vcm'?"));
    EXPECT_THAT(errorWith([](auto& o) { o.layers = {"color"}; }), HasSubstr("unknown AOV 'color'"));
    EXPECT_THAT(errorWith([](auto& o) { o.slices.count = 0; }), HasSubstr("found 0 slices"));
}

TEST(ApiImage, ComparesAsTheCommand) {
    Image a{{1, 1, 1, 2, 2, 2}, 1, 2, 3}, b{{1, 1, 1, 1, 1, 1}, 1, 2, 3};
    EXPECT_EQ(compare(a.view(), a.view()).relMse, 0);
    EXPECT_DOUBLE_EQ(compare(a.view(), b.view()).mse, 0.5);
    EXPECT_EQ(heatMap(a.view(), b.view()).pixels.size(), 6u);
    const Image gray{{0.5f, 1}, 1, 2, 1}, color{{0.5f, 0.5f, 0.5f, 1, 1, 1}, 1, 2, 3};
    EXPECT_EQ(displayImage(gray.view()), displayImage(color.view()));
    EXPECT_EQ(encodePng(gray.view()), encodePng(color.view()));
    const TemporaryFolder folder;
    writeImage(folder.path() / "srgb.png", gray.view());
    writeImage(folder.path() / "none.png", gray.view(), {0, "none"});
    EXPECT_NEAR(readImage(folder.path() / "srgb.png").pixels[0], 0.5, 0.005) << "read as linear";
    EXPECT_NEAR(readImage(folder.path() / "none.png").pixels[0], 0.214, 0.005) << "0.5 of a display";
    b.width = 1;
    EXPECT_NE(errorOf([&] { compare(a.view(), b.view()); }), "nothing was thrown");
}

}  // namespace
}  // namespace metrolux::core::test
