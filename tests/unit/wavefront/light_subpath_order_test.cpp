#include "wavefront/light_subpath_order.h"

#include "base/warp.h"
#include "support/small_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace metrolux::core {
namespace {

using test::SceneBuilder;

std::shared_ptr<Scene> litScene(bool withLights = true) {
    SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.7f));
    b.add(makeSphere(Transform(), {0, 1, 0}, 0.7f, false), makeDielectric({}));
    if (withLights) {
        b.emit(b.add(test::rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), test::diffuse(0.3f)), Rgb(5));
        b.emit(b.add(makeSphere(Transform(), {-1, 2, 1}, 0.1f, false), test::diffuse(0)), Rgb(20));
        PointLightParameters p;
        p.position = {2, 3, 0};
        b.light(makePointLight(p));
        b.light(makeConstantLight({Rgb(0.2f)}));
    }
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 24, 20);
    return b.build();
}

IndependentStream streamOf(size_t i) { return IndependentStream(hashKey(3, 7, i)); }

TEST(LightSubpathOrder, HasEachSubpathOnce) {
    const Strategies strategies = Strategies::bidirectional(1, 0);
    for (const bool withLights : {true, false}) {
        const std::shared_ptr<Scene> scene = litScene(withLights);
        const WalkRules walk{*scene, scene->parts().limits, strategies, TransportMode::Importance};
        for (const size_t count : {0, 1, 2, 7, 100, 1024, 5000, 40000}) {
            std::vector<uint32_t> order = coherentOrder(walk, count, streamOf);
            ASSERT_EQ(order.size(), count);
            std::sort(order.begin(), order.end());
            for (size_t i = 0; i < count; ++i) ASSERT_EQ(order[i], i);
        }
    }
}

/// First edges of successive subpaths pass near each other: origin and direction, over all kinds of lights.
TEST(LightSubpathOrder, SuccessiveSubpathsStartAlike) {
    const Strategies strategies = Strategies::bidirectional(1, 0);
    const std::shared_ptr<Scene> scene = litScene();
    const WalkRules walk{*scene, scene->parts().limits, strategies, TransportMode::Importance};
    constexpr size_t kCount = 20000;
    const std::vector<uint32_t> order = coherentOrder(walk, kCount, streamOf);
    const auto meanStep = [&](auto&& indexAt) {
        double sum = 0;
        Vec3f last(0.0f);
        for (size_t i = 0; i < kCount; ++i) {
            IndependentStream stream = streamOf(indexAt(i));
            LightStart start;
            if (!startLight(walk, stream, start)) continue;
            const Vec3f p = start.ray.origin + start.ray.direction * scene->bounds().radius;
            sum += (p - last).length();
            last = p;
        }
        return sum / kCount;
    };
    const double sorted = meanStep([&](size_t i) { return order[i]; });
    const double unsorted = meanStep([](size_t i) { return i; });
    EXPECT_LT(sorted, 0.15 * unsorted);
}

}  // namespace
}  // namespace metrolux::core
