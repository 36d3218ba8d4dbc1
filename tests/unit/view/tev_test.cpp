#include "base/clock.h"
#include "base/error.h"
#include "support/fake_tev.h"
#include "view/tev_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace metrolux::core::view {
namespace {

using test::FakeTev;
using test::PacketReader;
using testing::HasSubstr;

class TevTest : public testing::Test {
  protected:
    TevTest() {
        board.change([](BoardState& state) {
            state.sides.resize(1);
            state.sides[0].integrator = "path";
        });
    }
    void publish(int width, int height, float first) {
        Frame frame;
        frame.window = {0, 0, width, height};
        frame.color.resize(3 * static_cast<size_t>(width * height), 0.5f);
        frame.color[0] = first;
        board.publish(0, std::move(frame), 0);
        if (client) client->notify();
    }
    void connect(const std::string& port) {
        client = std::make_unique<TevClient>("127.0.0.1:" + port, board, [this](const std::string& text) {
            const std::lock_guard lock(mutex);
            warnings.push_back(text);
        });
        client->notify();
    }
    size_t warned() {
        const std::lock_guard lock(mutex);
        return warnings.size();
    }
    void expectCreated(int width, int height) {
        PacketReader create(tev.packet());
        create.number<uint32_t>();
        EXPECT_EQ(create.number<char>(), 4);
        EXPECT_EQ(create.number<char>(), 0) << "the focus stays";
        EXPECT_EQ(create.text(), "lamp (path)");
        EXPECT_EQ(create.number<int32_t>(), width);
        EXPECT_EQ(create.number<int32_t>(), height);
        EXPECT_EQ(create.number<int32_t>(), 3);
        for (const char* channel : {"R", "G", "B"}) EXPECT_EQ(create.text(), channel);
        EXPECT_EQ(create.rest(), 0u);
    }
    /// Returns the first float.
    float expectUpdated(int y, int width, int height) {
        PacketReader update(tev.packet());
        update.number<uint32_t>();
        EXPECT_EQ(update.number<char>(), 6);
        EXPECT_EQ(update.number<char>(), 0);
        EXPECT_EQ(update.text(), "lamp (path)");
        EXPECT_EQ(update.number<int32_t>(), 3);
        for (const char* channel : {"R", "G", "B"}) EXPECT_EQ(update.text(), channel);
        for (const int32_t expected : {0, y, width, height}) EXPECT_EQ(update.number<int32_t>(), expected);
        for (const int64_t offset : {0, 1, 2}) EXPECT_EQ(update.number<int64_t>(), offset);
        for (int i = 0; i < 3; ++i) EXPECT_EQ(update.number<int64_t>(), 3);
        EXPECT_EQ(update.rest(), size_t(12 * width * height));
        return update.number<float>();
    }

    Board board{{"lamp", false, {}, {}}};
    FakeTev tev;
    std::mutex mutex;
    std::vector<std::string> warnings;
    std::unique_ptr<TevClient> client;
};

TEST_F(TevTest, SendsWhatTheProtocolSays) {
    publish(5, 4, 0.25f);
    connect(std::to_string(tev.port));
    ASSERT_TRUE(tev.accept());
    expectCreated(5, 4);
    EXPECT_EQ(expectUpdated(0, 5, 4), 0.25f);
    publish(5, 4, 0.75f);
    EXPECT_EQ(expectUpdated(0, 5, 4), 0.75f);
    publish(2, 3, 1);
    PacketReader close(tev.packet());
    close.number<uint32_t>();
    EXPECT_EQ(close.number<char>(), 2);
    EXPECT_EQ(close.text(), "lamp (path)");
    expectCreated(2, 3);
    expectUpdated(0, 2, 3);
    EXPECT_EQ(warned(), 0u);
}

TEST_F(TevTest, LargeImagesComeInBands) {
    publish(1000, 500, 0.25f);
    connect(std::to_string(tev.port));
    ASSERT_TRUE(tev.accept());
    expectCreated(1000, 500);
    const int rows = (4 << 20) / 12000;
    expectUpdated(0, 1000, rows);
    expectUpdated(rows, 1000, 500 - rows);
}

TEST_F(TevTest, WhoGoesAwayMayComeAgain) {
    publish(5, 4, 1);
    connect(std::to_string(tev.port));
    ASSERT_TRUE(tev.accept());
    expectCreated(5, 4);
    expectUpdated(0, 5, 4);
    tev.hangUp();
    for (int i = 0; i < 100 && warned() == 0; ++i) {
        publish(5, 4, 2);
        ::usleep(20000);
    }
    EXPECT_EQ(warned(), 1u);
    std::jthread renderer([this](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
            publish(5, 4, 3);
            ::usleep(50000);
        }
    });
    ASSERT_TRUE(tev.accept(10000)) << "it is tried again";
    expectCreated(5, 4);
    EXPECT_EQ(warned(), 1u);
}

TEST_F(TevTest, WhoStallsHoldsNobodyUp) {
    publish(2000, 2000, 1);
    connect(std::to_string(tev.port));
    ASSERT_TRUE(tev.accept());  // and never reads
    ::usleep(200000);
    const double start = steadySeconds();
    publish(2000, 2000, 2);
    EXPECT_LT(steadySeconds() - start, 1);
    client.reset();
    EXPECT_LT(steadySeconds() - start, 14);
}

TEST_F(TevTest, NobodyThereIsAWarning) {
    const uint16_t port = [] { return FakeTev().port; }();
    publish(5, 4, 1);
    connect(std::to_string(port));
    for (int i = 0; i < 200 && warned() == 0; ++i) ::usleep(20000);
    client.reset();
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_THAT(warnings[0], AllOf(HasSubstr(std::to_string(port)), HasSubstr("refused")));
}

TEST_F(TevTest, AddressesThatAreNone) {
    for (const char* address : {"", ":14158", "host:", "host:0", "host:70000", "host:x"})
        EXPECT_THROW(TevClient(address, board, {}), Error) << address;
}

}  // namespace
}  // namespace metrolux::core::view
