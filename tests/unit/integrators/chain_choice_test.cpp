#include "integrators/chain_choice.h"

#include <gtest/gtest.h>

#include <vector>

namespace metrolux::core {
namespace {

/// Passes of chains among the first `passes`, if chains have this gain.
std::vector<int> chainPasses(int passes, double gain) {
    ChainChoice choice;
    std::vector<int> result;
    for (int pass = 0; pass < passes; ++pass) {
        if (choice.chains()) result.push_back(pass);
        choice.endPass(gain);
    }
    return result;
}

TEST(ChainChoice, IndependentSubpathsWhereChainsAreNoHelp) {
    EXPECT_EQ(chainPasses(70, 0.6), (std::vector<int>{0, 1, 2, 3, 16, 17, 32, 33, 64, 65}));
}

TEST(ChainChoice, ChainsWhereTheyHelp) { EXPECT_EQ(chainPasses(70, 1.5).size(), 70u); }

TEST(ChainChoice, ChangesItsMindWhenTriedAgain) {
    ChainChoice choice;
    for (int pass = 0; pass < 16; ++pass) choice.endPass(0.6);
    EXPECT_TRUE(choice.judging());
    choice.endPass(3);
    choice.endPass(3);
    EXPECT_FALSE(choice.judging());
    EXPECT_TRUE(choice.chains());
}

}  // namespace
}  // namespace metrolux::core
