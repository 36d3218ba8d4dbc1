#include "integrators/light_subpath_choice.h"

#include <gtest/gtest.h>

#include <string>

namespace metrolux::core {
namespace {

/// A letter for each of the first passes, if chains have this gain and none this verdict.
std::string passes(int count, double gain, bool noneMayDo, bool noneWins) {
    LightSubpathChoice choice(noneMayDo);
    std::string result;
    for (int pass = 0; pass < count; ++pass) {
        result += "CIN"[static_cast<int>(choice.next())];
        choice.endPass(gain, [&] { return noneWins; });
    }
    return result;
}

TEST(LightSubpathChoice, IndependentOnesWhereChainsAreNoHelp) {
    const std::string judged = "CC", between(14, 'I');
    EXPECT_EQ(passes(36, 0.6, false, false),
              "CCCC" + std::string(12, 'I') + judged + between + judged + "II");
    EXPECT_EQ(passes(36, 0.6, true, false), passes(36, 0.6, false, false));
}

TEST(LightSubpathChoice, ChainsWhereTheyHelp) {
    EXPECT_EQ(passes(70, 1.5, true, false), std::string(70, 'C'));
    EXPECT_EQ(passes(70, 1.5, false, true), std::string(70, 'C')) << "nobody asks where none cannot do";
}

TEST(LightSubpathChoice, NoneWhereEyeSubpathsDoBest) {
    EXPECT_EQ(passes(70, 1.5, true, true),
              "CCCC" + std::string(12, 'N') + "CC" + std::string(46, 'N') + "CC" + "NNNN");
    EXPECT_EQ(passes(24, 0.6, true, true), "CCCCII" + std::string(10, 'N') + "CCII" + "NNNN");
}

TEST(LightSubpathChoice, ChangesItsMindWhenTriedAgain) {
    LightSubpathChoice choice(true);
    const auto no = [] { return false; };
    for (int pass = 0; pass < 16; ++pass) choice.endPass(0.6, no);
    EXPECT_TRUE(choice.judging());
    EXPECT_EQ(choice.chosen(), LightSubpaths::Independent);
    choice.endPass(3, no);
    choice.endPass(3, no);
    EXPECT_FALSE(choice.judging());
    EXPECT_EQ(choice.next(), LightSubpaths::Chains);
}

TEST(LightSubpathChoice, KnowsHalfOfTheWayToTheNextTrial) {
    LightSubpathChoice choice(true);
    std::string result;
    for (int pass = 0; pass < 70; ++pass) {
        if (choice.halfWay()) result += std::to_string(pass) + ' ';
        choice.endPass(1, [] { return false; });
    }
    EXPECT_EQ(result, "8 18 34 66 ");
}

}  // namespace
}  // namespace metrolux::core
