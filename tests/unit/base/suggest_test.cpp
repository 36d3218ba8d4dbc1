#include "base/suggest.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

const std::vector<std::string> kNames = {"diffuse", "roughconductor", "dielectric", "to_world",
                                         "path",    "bdpt",           "vcm"};

TEST(Suggest, FindsWhatWasMeant) {
    EXPECT_EQ(nearestName("difuse", kNames), "diffuse");
    EXPECT_EQ(nearestName("rough_conductor", kNames), "roughconductor");
    EXPECT_EQ(nearestName("toWorld", kNames), "to_world");
    EXPECT_EQ(nearestName("Dielectrics", kNames), "dielectric");
    EXPECT_EQ(nearestName("bdtp", kNames), "bdpt");
    EXPECT_EQ(nearestName("vmc", kNames), "vcm");  // neighbors exchanged: one slip
}

TEST(Suggest, SaysNothingWhenNothingIsNear) {
    EXPECT_EQ(nearestName("subsurface", kNames), "");
    EXPECT_EQ(nearestName("", kNames), "");
    EXPECT_EQ(nearestName("x", {"y"}), "");
    EXPECT_EQ(nearestName("path", {}), "");
}

TEST(Suggest, PrefersTheNearerName) {
    EXPECT_EQ(nearestName("plastik", {"elastic", "plastic", "roughplastic"}), "plastic");
}

}  // namespace
}  // namespace metrolux::core
