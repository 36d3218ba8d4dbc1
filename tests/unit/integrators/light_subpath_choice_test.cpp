#include "integrators/light_subpath_choice.h"

#include <gtest/gtest.h>

#include <string>

namespace metrolux::core {
namespace {

/// A letter for each of the first passes, if chains have this gain and none this loss.
std::string passes(int count, double gain, bool noneMayDo, double loss) {
    LightSubpathChoice choice(noneMayDo);
    std::string result;
    for (int pass = 0; pass < count; ++pass) {
        result += "CIN"[static_cast<int>(choice.next())];
        choice.endPass(gain, [&] { return loss; });
    }
    return result;
}

TEST(LightSubpathChoice, IndependentOnesWhereChainsAreNoHelp) {
    const std::string judged = "CC", between(14, 'I');
    EXPECT_EQ(passes(36, 0.6, false, 2), "CCCC" + std::string(12, 'I') + judged + between + judged + "II");
    EXPECT_EQ(passes(36, 0.6, true, 2), passes(36, 0.6, false, 2));
}

TEST(LightSubpathChoice, ChainsWhereTheyHelp) {
    EXPECT_EQ(passes(70, 1.5, true, 2), std::string(70, 'C'));
    EXPECT_EQ(passes(70, 1.5, false, 0.1), std::string(70, 'C')) << "nobody asks where none cannot do";
}

TEST(LightSubpathChoice, NoneWhereEyeSubpathsDoBest) {
    EXPECT_EQ(passes(70, 1.5, true, 0.9),
              "CCCC" + std::string(12, 'N') + "CC" + std::string(46, 'N') + "CC" + "NNNN");
    EXPECT_EQ(passes(24, 0.6, true, 0.9), "CCCCII" + std::string(10, 'N') + "CCII" + "NNNN");
}

TEST(LightSubpathChoice, NoneWithoutASecondLookWhereThatIsClear) {
    EXPECT_EQ(passes(38, 1.5, true, 0.5), "CCCC" + std::string(28, 'N') + "CC" + "NNNN");
    // Independent ones cannot make less than 0.8 of the noise of the chains.
    EXPECT_EQ(passes(38, 0.8, true, 0.5), passes(38, 1.5, true, 0.5));
    EXPECT_EQ(passes(20, 0.8, true, 0.7), "CCCC" + std::string(12, 'N') + "CC" + "NN")
        << "clear, but not by far";
    EXPECT_EQ(passes(10, 0.4, true, 0.5), "CCCCII" + std::string(4, 'N'));
}

TEST(LightSubpathChoice, ChangesItsMindWhenTriedAgain) {
    LightSubpathChoice choice(true);
    const auto no = [] { return 2.0; };
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
        choice.endPass(1, [] { return 2.0; });
    }
    EXPECT_EQ(result, "8 18 34 66 ");
}

}  // namespace
}  // namespace metrolux::core
