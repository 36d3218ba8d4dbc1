#include "view/explorer.h"

#include "api/internals.h"
#include "base/clock.h"
#include "base/parallel.h"
#include "support/temporary_folder.h"
#include "view/watched.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <thread>

namespace metrolux::core::view {
namespace {

namespace fs = std::filesystem;
using metrolux::Object;
using metrolux::Reference;
using testing::HasSubstr;
using Kind = Command::Kind;

metrolux::Scene lampScene(int width = 24, int height = 16) {
    const Object film("hdrfilm", {{"width", width}, {"height", height}});
    const auto camera = metrolux::Transform::lookAt({0, 2, 6}, {0, 0, 0}, {0, 1, 0});
    return metrolux::Scene::make(Object(
        "scene", {{"integrator", Object("path", {{"max_depth", 5}})},
                  {"camera", Object("perspective", {{"fov", 40.0}, {"to_world", camera}, {"film", film}})},
                  {"ball", Object("sphere", {{"radius", 1.0}, {"bsdf", Object("diffuse")}})},
                  {"sky", Object("constant", {{"radiance", metrolux::Color{1, 1, 1}}})}}));
}

/// An explorer at work, and who watches it.
class ExplorerTest : public testing::Test {
  protected:
    void start(const metrolux::Scene& scene, ExplorerOptions options = {}) {
        if (options.session.integrator == metrolux::kDefaultIntegrator) options.session.integrator = "path";
        options.interrupted = [this] { return ends_.load(); };
        thread_ = std::thread([this, scene, options] {
            Explorer explorer(scene, options, board);
            result = explorer.run();
        });
    }
    void end() {
        ends_ = true;
        if (thread_.joinable()) thread_.join();
    }
    ~ExplorerTest() override { end(); }

    template <class Condition>
    BoardState waitFor(const Condition& condition) {
        for (int i = 0; i < 6000; ++i) {
            board.watch(false);
            BoardState state = board.state();
            if (condition(state)) return state;
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        ADD_FAILURE() << "waited in vain; the last message: " << board.state().message;
        return board.state();
    }
    BoardState waitForPasses(uint32_t passes, size_t side = 0) {
        return waitFor([&](const BoardState& s) {
            return s.sides.size() > side && s.sides[side].frame && s.sides[side].frame->scale == 1 &&
                   s.sides[side].frame->generation == s.sides[side].generation &&
                   s.sides[side].frame->progress.passes >= passes;
        });
    }
    void post(Kind kind, const std::string& integrator = {}, std::optional<metrolux::Crop> crop = {}) {
        ASSERT_TRUE(board.post({kind, {}, crop, integrator}));
    }
    void turn(double yaw) { ASSERT_TRUE(board.post({Kind::Move, {true, yaw, 0, 1, 0, 0}, {}, {}})); }

    test::TemporaryFolder folder;
    Board board{{"lamp", true, {"depth"}, {}}};
    Explorer::Result result;

  private:
    std::atomic<bool> ends_{false};
    std::thread thread_;
};

TEST_F(ExplorerTest, HasTheBitsOfAPlainRendering) {
    const metrolux::Scene scene = lampScene();
    ExplorerOptions options;
    options.limits.passes = 5;
    start(scene, options);
    const BoardState state = waitFor([](const BoardState& s) { return s.phase == Phase::Done; });
    EXPECT_THAT(state.reason, HasSubstr("number of passes"));
    options.session.integrator = "path";
    Session plain(scene, options.session);
    plain.render(options.limits);
    const ImageView image = plain.image();
    const Frame& frame = *state.sides[0].frame;
    ASSERT_EQ(frame.color.size(), image.size());
    EXPECT_EQ(std::memcmp(frame.color.data(), image.data, image.size() * sizeof(float)), 0);
    end();
    EXPECT_EQ(result.outcome.reason, metrolux::StopReason::Passes);
}

TEST_F(ExplorerTest, APauseLastsUntilItIsOver) {
    start(lampScene());
    waitForPasses(1);
    post(Kind::Pause);
    const uint32_t passes =
        waitFor([](const BoardState& s) { return s.phase == Phase::Paused; }).sides[0].progress.passes;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    EXPECT_EQ(board.state().sides[0].progress.passes, passes);
    EXPECT_EQ(board.state().sides[0].frame->progress.passes, passes) << "the last picture is the whole";
    post(Kind::Resume);
    waitForPasses(passes + 1);
    post(Kind::Stop);
    waitFor([](const BoardState& s) { return s.phase == Phase::Stopped; });
    turn(0.3);
    waitFor([](const BoardState& s) { return s.phase == Phase::Rendering; });
}

TEST_F(ExplorerTest, ANewCameraEndsTheLongestPass) {
    // A pass of this takes seconds, four times what the last preview takes.
    ExplorerOptions options;
    options.session.integrator = "vcm";
    start(lampScene(1000, 750), options);
    const BoardState preview = waitFor([](const BoardState& s) {
        return s.sides.size() == 1 && s.sides[0].frame && s.sides[0].frame->scale == 2;
    });
    const double pass = 4 * preview.sides[0].frame->progress.seconds;
    std::this_thread::sleep_for(std::chrono::duration<double>(0.25 * pass));
    const uint64_t before = board.state().sides[0].generation;
    const double start = steadySeconds();
    turn(0.5);
    const BoardState state = waitFor([&](const BoardState& s) {
        return s.sides[0].generation > before && s.sides[0].frame->generation == s.sides[0].generation;
    });
    // Where the machine is so busy that a pass takes longer than usual, everything does.
    EXPECT_LT(steadySeconds() - start, std::max(1.0, 0.5 * pass));
    EXPECT_GT(state.sides[0].frame->scale, 1) << "a preview";
}

TEST_F(ExplorerTest, TheCameraTurnsAroundWhatIsSeen) {
    start(lampScene());
    waitForPasses(1);
    const auto placeOf = [](const BoardState& s) { return Vector{s.camera[3], s.camera[7], s.camera[11]}; };
    turn(std::acos(0.0));
    const Vector turned = placeOf(waitFor([](const BoardState& s) { return s.camera[3] > 5; }));
    // The pivot is where the ball is met: on the way from (0, 2, 6) to the origin, one unit before it.
    const double pivot = 6 / std::sqrt(40.0);
    EXPECT_NEAR(turned.x, 6 - pivot, 1e-3);
    EXPECT_NEAR(turned.y, 2, 1e-3);
    EXPECT_NEAR(turned.z, pivot, 1e-3);
    ASSERT_TRUE(board.post({Kind::Move, {false, 0, 0, 0.5, 0, 0}, {}, {}}));
    const Vector near = placeOf(waitFor([](const BoardState& s) { return s.camera[3] < 4; }));
    EXPECT_NEAR(near.x, (6 - pivot) / 2, 1e-3);
    post(Kind::ResetCamera);
    waitFor([&](const BoardState& s) { return s.camera[3] == 0 && s.camera[7] == 2 && s.camera[11] == 6; });
}

TEST_F(ExplorerTest, ACropIsRenderedAlone) {
    start(lampScene());
    waitForPasses(1);
    post(Kind::Crop, {}, metrolux::Crop{4, 3, 10, 6});
    BoardState state = waitFor([](const BoardState& s) { return s.window.width == 10; });
    state = waitForPasses(1);
    EXPECT_EQ(state.sides[0].frame->color.size(), 180u);
    EXPECT_EQ(state.resolution.width, 24);
    post(Kind::Crop);
    waitFor([](const BoardState& s) { return s.window.width == 24; });
}

TEST_F(ExplorerTest, TwoIntegratorsShareTheTime) {
    start(lampScene(64, 48));
    waitForPasses(1);
    post(Kind::Compare, "pt_mis_is_no_integrator");
    waitFor([](const BoardState& s) { return s.messageIsError; });
    post(Kind::Compare, "bdpt");
    const BoardState state = waitForPasses(4, 1);
    EXPECT_EQ(state.sides[1].integrator, "bdpt");
    waitFor([](const BoardState& s) { return s.sides[1].progress.seconds > 0.5; });
    const BoardState later = board.state();
    EXPECT_GT(later.sides[0].progress.passes, 1u);
    post(Kind::Compare);
    waitFor([](const BoardState& s) { return s.sides.size() == 1; });
}

TEST_F(ExplorerTest, SavingWritesByTheRulesOfRender) {
    ExplorerOptions options;
    options.files.images = {folder.path() / "a.exr"};
    start(lampScene(), options);
    waitForPasses(2);
    post(Kind::Pause);
    waitFor([](const BoardState& s) { return s.phase == Phase::Paused; });
    post(Kind::Save);
    const BoardState state = waitFor([](const BoardState& s) { return !s.message.empty(); });
    EXPECT_THAT(state.message, HasSubstr("a.exr"));
    EXPECT_FALSE(state.messageIsError) << state.message;
    EXPECT_TRUE(fs::exists(folder.path() / "a.checkpoint"));
    const metrolux::Image saved = metrolux::readImage(folder.path() / "a.exr");
    EXPECT_EQ(std::memcmp(saved.pixels.data(), state.sides[0].frame->color.data(),
                          saved.pixels.size() * sizeof(float)),
              0);
    // A picture that another program has made stays.
    folder.write("a.exr", "a picture of somebody else");
    post(Kind::Save);
    EXPECT_THAT(waitFor([](const BoardState& s) { return s.messageNumber == 2; }).message,
                HasSubstr("a.exr"));
    EXPECT_TRUE(board.state().messageIsError);
    fs::remove(folder.path() / "a.exr");
    end();
    EXPECT_TRUE(fs::exists(folder.path() / "a.exr")) << "as at the end of render";
    EXPECT_EQ(result.outcome.reason, metrolux::StopReason::Interrupted);
}

TEST_F(ExplorerTest, LayersAndVarianceComeWhenTheyAreWanted) {
    start(lampScene());
    waitForPasses(2);
    post(Kind::Pause);
    waitFor([](const BoardState& s) { return s.phase == Phase::Paused; });
    EXPECT_TRUE(board.state().sides[0].frame->variance.empty());
    board.watch(true);
    waitFor([](const BoardState& s) { return !s.sides[0].frame->variance.empty(); });
    waitFor([&](const BoardState&) { return board.layer(0, "depth") != nullptr; });
    EXPECT_EQ(board.layer(0, "depth")->values.size(), 24u * 16u);
}

TEST_F(ExplorerTest, AnImpossibleFirstRenderingIsAnError) {
    ExplorerOptions options;
    options.session.integrator = "path";
    options.session.parameters["no_such_parameter"] = 1.0;
    options.interrupted = [] { return false; };
    Explorer explorer(lampScene(), options, board);
    EXPECT_THROW(explorer.run(), Error);
}

TEST(Watched, ViewersDoNotChangeTheImage) {
    const metrolux::Scene scene = lampScene();
    metrolux::SessionOptions options;
    options.integrator = "path";
    Limits limits;
    limits.passes = 6;
    Board board({"lamp", false, {}, {}});
    Session session(scene, options), plain(scene, options);
    plain.render(limits);
    uint32_t paused = 0;
    Hooks hooks;
    hooks.progress = [&](const Progress& progress) {
        if (progress.passes == 3) board.post({Kind::Pause, {}, {}, {}});
    };
    std::jthread viewer([&] {
        while (board.state().phase != Phase::Paused)
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        paused = board.state().sides[0].frame->progress.passes;
        board.post({Kind::Resume, {}, {}, {}});
    });
    const Outcome outcome = renderWatched(session, limits, hooks, {}, board);
    viewer.join();
    EXPECT_EQ(paused, 3u);
    EXPECT_EQ(outcome.reason, metrolux::StopReason::Passes);
    EXPECT_EQ(outcome.passes, 6u);
    const ImageView a = session.image(), b = plain.image();
    EXPECT_EQ(std::memcmp(a.data, b.data, a.size() * sizeof(float)), 0);
    EXPECT_EQ(board.state().sides[0].frame->progress.passes, 6u);
}

TEST(Watched, AViewerMayStopIt) {
    metrolux::SessionOptions options;
    options.integrator = "path";
    Session session(lampScene(), options);
    Board board({"lamp", false, {}, {}});
    Hooks hooks;
    hooks.progress = [&](const Progress& progress) {
        if (progress.passes == 2) board.post({Kind::Stop, {}, {}, {}});
    };
    Limits limits;
    limits.passes = 1000000;
    const Outcome outcome = renderWatched(session, limits, hooks, {}, board);
    EXPECT_EQ(outcome.reason, metrolux::StopReason::Interrupted);
    EXPECT_EQ(outcome.passes, 2u);
    EXPECT_EQ(board.state().phase, Phase::Stopped);
}

TEST(Cancel, EndsAPassForGood) {
    metrolux::SessionOptions options;
    options.integrator = "path";
    Session session(lampScene(), options);
    session.step();
    Internals::cancel(session);
    EXPECT_THROW(session.step(), Canceled);
    EXPECT_THROW(session.render({}, {}), Canceled);
}

}  // namespace
}  // namespace metrolux::core::view
