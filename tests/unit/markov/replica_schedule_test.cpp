/// How an iteration's samples are dealt out, and how visible ones wait for the chains.

#include "markov/replica_schedule.h"

#include "markov/replica_pool.h"

#include <gtest/gtest.h>

#include <numeric>

namespace metrolux::core {
namespace {

struct Sized {
    double size = 0;
    bool visible() const { return size > 0; }
};

TEST(ReplicaSchedule, LanesShareAllSteps) {
    for (const size_t steps : {0u, 5u, 600u, 1001u}) {
        size_t sum = 0;
        for (size_t lane = 0; lane < 7; ++lane) {
            const size_t part = stepsOfLane(steps, 7, lane);
            EXPECT_GE(part, steps / 7);
            EXPECT_LE(part, steps / 7 + 1);
            sum += part;
        }
        EXPECT_EQ(sum, steps);
    }
}

TEST(ReplicaSchedule, SamplesAreInProportionAndTheSameInEveryLane) {
    const auto even = replicaSamples({2, 1, 3}, 6000, 10);
    EXPECT_EQ(even, (std::array<double, 3>{2000, 1000, 3000}));
    const auto few = replicaSamples({1, 0, 1000}, 100, 8);
    EXPECT_EQ(few, (std::array<double, 3>{8, 0, 104}));  // one in each lane at least, rounded up
}

TEST(ReplicaSchedule, StepsSpreadTheSamplesOfEveryReplica) {
    ReplicaMixture mix;
    mix.uniform = 40;
    mix.visibility = 8;
    mix.contribution = 20;
    const ReplicaSchedule schedule(mix, 4);
    ASSERT_EQ(schedule.steps(), 10u);
    EXPECT_EQ(schedule.uniformSamples(), 10u);
    std::vector<size_t> visibility, contribution;
    for (size_t step = 0; step < schedule.steps(); ++step) {
        const ReplicaSchedule::Due due = schedule.at(step);
        EXPECT_TRUE(due.uniform);
        if (due.visibility) visibility.push_back(step);
        if (due.contribution) contribution.push_back(step);
    }
    EXPECT_EQ(visibility, (std::vector<size_t>{4, 9}));
    EXPECT_EQ(contribution, (std::vector<size_t>{1, 3, 5, 7, 9}));
}

TEST(ReplicaPool, QueueGivesVisibleSamplesAtTheirTurn) {
    UniformQueue<Sized> queue;
    for (const double size : {0.0, 2.0, 0.0, 5.0}) {
        MarkovState<Sized> state = queue.spare();
        EXPECT_TRUE(state.u.empty());
        EXPECT_EQ(state.weight, 0);
        state.value.size = size;
        state.u = {0.5f};
        state.weight = 1;
        queue.add(std::move(state));
    }
    EXPECT_EQ(queue.added(), 4u);
    EXPECT_EQ(queue.visible(), 2u);
    EXPECT_EQ(queue.take(), nullptr);
    EXPECT_EQ(queue.take()->value.size, 2);
    EXPECT_EQ(queue.take(), nullptr);
    EXPECT_FALSE(queue.empty());
    EXPECT_EQ(queue.take()->value.size, 5);
    EXPECT_TRUE(queue.empty());
    queue.forget();
    EXPECT_EQ(queue.visible(), 0u);
    EXPECT_EQ(queue.added(), 4u);
    queue.clear();
    EXPECT_EQ(queue.added(), 0u);
}

TEST(ReplicaPool, StartsFollowTheTargets) {
    UniformQueue<Sized> queue;
    for (const double size : {1.0, 0.0, 3.0}) {
        MarkovState<Sized> state;
        state.value.size = size;
        queue.add(std::move(state));
    }
    ReplicaPool<Sized> pool;
    EXPECT_TRUE(pool.empty());
    pool.add(queue);
    EXPECT_EQ(pool.visible(), 2);
    EXPECT_EQ(pool.sumOfSizes(), 4);
    const auto large = [](const std::vector<const MarkovState<Sized>*>& states) {
        return std::count_if(states.begin(), states.end(), [](auto* s) { return s->value.size == 3; });
    };
    for (const double offset : {0.01, 0.5, 0.99}) {
        EXPECT_EQ(large(pool.draw(8, offset)), 4);
        EXPECT_EQ(large(pool.drawBySize(8, offset)), 6);
    }
}

}  // namespace
}  // namespace metrolux::core
