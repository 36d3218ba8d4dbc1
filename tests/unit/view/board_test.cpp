#include "view/board.h"

#include "base/error.h"
#include "view/command_text.h"
#include "view/frame.h"

#include <Imath/half.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace metrolux::core::view {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Kind = Command::Kind;

Command moveBy(double yaw, bool begins = false) {
    Command command;
    command.kind = Kind::Move;
    command.motion.yaw = yaw;
    command.motion.begins = begins;
    return command;
}

TEST(Board, MotionsOfADragAreOne) {
    Board board({});
    EXPECT_FALSE(board.hasCommands());
    EXPECT_TRUE(board.post(moveBy(1, true)));
    EXPECT_TRUE(board.post(moveBy(2)));
    EXPECT_TRUE(board.post(moveBy(4, true)));
    EXPECT_TRUE(board.hasCommands());
    const std::vector<Command> commands = board.take();
    ASSERT_EQ(commands.size(), 2u);
    EXPECT_EQ(commands[0].motion.yaw, 3);
    EXPECT_EQ(commands[1].motion.yaw, 4);
    EXPECT_FALSE(board.hasCommands());
}

TEST(Board, CommandsAreBounded) {
    Board board({});
    size_t taken = 0;
    while (taken < 1000 && board.post({})) ++taken;
    EXPECT_LT(taken, 100u);
    board.take();
    EXPECT_TRUE(board.post({}));
}

TEST(Board, OnlyWhatMakesAPassWorthlessIsUrgent) {
    Board board({});
    int urgent = 0;
    board.onUrgent([&] { ++urgent; });
    board.change([](BoardState& state) { state.sides.resize(1); });
    for (const Kind kind : {Kind::Pause, Kind::Save, Kind::Stop, Kind::Compare})
        board.post({kind, {}, {}, {}});
    EXPECT_EQ(urgent, 0);
    board.post(moveBy(1));
    board.post({Kind::Integrator, {}, {}, "path"});
    EXPECT_EQ(urgent, 2);
    board.change([](BoardState& state) { state.sides.resize(2); });
    board.post({Kind::Integrator, {}, {}, "path"});
    EXPECT_EQ(urgent, 2) << "the other side goes on";
}

TEST(Board, FramesTakeASmallShareOfTheTime) {
    Board board({});
    board.change([](BoardState& state) { state.sides.resize(2); });
    EXPECT_TRUE(board.isDue(0));
    board.publish(0, {}, 10);
    EXPECT_FALSE(board.isDue(0)) << "the next in a thousand seconds";
    EXPECT_TRUE(board.isDue(1));
    EXPECT_EQ(board.state().sides[0].frame->version, 1u);
}

TEST(Board, TheCurveStaysShort) {
    Board board({});
    board.change([](BoardState& state) { state.sides.resize(1); });
    Progress progress;
    board.pass(0, progress);
    EXPECT_TRUE(board.state().sides[0].curve.empty()) << "the error is not known yet";
    for (int i = 1; i <= 100000; ++i) {
        progress.seconds = i;
        progress.relativeError = 1 / std::sqrt(double(i));
        board.pass(0, progress);
    }
    const auto curve = board.state().sides[0].curve;
    EXPECT_GT(curve.size(), 100u);
    EXPECT_LT(curve.size(), 257u);
    EXPECT_EQ(curve.front().first, 1);
    EXPECT_TRUE(std::is_sorted(curve.begin(), curve.end()));
}

TEST(Board, ALayerIsAskedForOnce) {
    Board board({});
    EXPECT_EQ(board.layer(0, "depth"), nullptr);
    EXPECT_EQ(board.layer(0, "depth"), nullptr);
    EXPECT_THAT(board.wishes(), ElementsAre(std::pair(0, std::string("depth"))));
    board.fulfill(0, "depth", {1, 1, 1, {2.5f}});
    EXPECT_TRUE(board.wishes().empty());
    EXPECT_EQ(board.layer(0, "depth")->values[0], 2.5f);
    board.forgetLayers();
    EXPECT_EQ(board.layer(0, "depth"), nullptr);
}

TEST(CommandText, ReadsCommands) {
    EXPECT_EQ(commandFromText(R"({"do":"pause"})").kind, Kind::Pause);
    const Command move = commandFromText(R"({"do":"move","begins":true,"yaw":0.5,"dolly":2})");
    EXPECT_EQ(move.kind, Kind::Move);
    EXPECT_TRUE(move.motion.begins);
    EXPECT_EQ(move.motion.yaw, 0.5);
    EXPECT_EQ(move.motion.dolly, 2);
    const Command crop = commandFromText(R"({"do":"crop","x":1,"y":2,"width":3,"height":4})");
    EXPECT_EQ(crop.crop->height, 4);
    EXPECT_FALSE(commandFromText(R"({"do":"crop"})").crop);
    EXPECT_EQ(commandFromText(R"({"do":"compare","integrator":"path"})").integrator, "path");
    EXPECT_EQ(commandFromText(R"({"do":"compare"})").integrator, "");
}

TEST(CommandText, RefusesWhatIsNone) {
    const std::pair<std::string, const char*> cases[] = {
        {"", "JSON object"},
        {"[1]", "JSON object"},
        {"{\"do\":", "JSON object"},
        {std::string(16000, '['), "JSON object"},
        {"{}", "found the command ''"},
        {R"({"do":7})", "type"},
        {R"({"do":"fly"})", "'fly', expected pause"},
        {R"({"do":"move","yaw":1e300})", "yaw: found 1e+300, expected a number from"},
        {R"({"do":"move","dolly":0})", "dolly"},
        {R"({"do":"move","yaw":"north"})", "yaw"},
        {R"({"do":"crop","x":0,"y":0,"width":1.5,"height":1})", "whole number"},
        {R"({"do":"crop","width":3})", "x: found"},
        {R"({"do":"integrator"})", "no integrator ''"},
        {R"({"do":"integrator","integrator":"magic"})", "no integrator 'magic'"},
    };
    for (const auto& [text, message] : cases) {
        try {
            commandFromText(text);
            ADD_FAILURE() << text.substr(0, 60);
        } catch (const Error& error) {
            EXPECT_THAT(error.what(), HasSubstr(message)) << text.substr(0, 60);
        }
    }
}

TEST(Frame, HalfFloats) {
    const float values[] = {0, 1, -2.5f, 0.1f, 1e9f, 6e-8f, NAN};
    const std::string bytes = halfFloats(values);
    ASSERT_EQ(bytes.size(), 14u);
    for (size_t i = 0; i < 7; ++i) {
        Imath::half half;
        half.setBits(static_cast<uint16_t>(static_cast<unsigned char>(bytes[2 * i]) |
                                           static_cast<unsigned char>(bytes[2 * i + 1]) << 8));
        if (std::isnan(values[i]))
            EXPECT_TRUE(half.isNan());
        else
            EXPECT_EQ(half, Imath::half(values[i]));
    }
}

TEST(Frame, RelativeErrors) {
    // Two gray pixels of 1 and 3: the mean is 2, and 0.04 is added to the squares.
    const std::vector<float> color{1, 1, 1, 3, 3, 3}, variance{0.01f, 0.09f};
    const std::vector<float> errors = relativeErrors(color, variance);
    EXPECT_NEAR(errors[0], std::sqrt(0.01 / 1.04), 1e-5);
    EXPECT_NEAR(errors[1], std::sqrt(0.09 / 9.04), 1e-5);
    EXPECT_EQ(relativeErrors(std::vector<float>{0, 0, 0}, std::vector<float>{0})[0], 0);
}

}  // namespace
}  // namespace metrolux::core::view
