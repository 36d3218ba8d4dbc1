#include "markov/mixture_density.h"

#include "base/rng.h"
#include "markov/replica_mixture.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

/// u in [0, 1): F = 1 and something shared below 0.9, F = 9 and nothing shared above.
struct Toy {
    double size, shared;
};
Toy toyAt(double u) { return u < 0.9 ? Toy{1, 0.5} : Toy{9, 0}; }

TEST(MixtureDensity, IsTheHarmonicMeanOverWhatIsShared) {
    ReplicaMixture mix;
    mix.uniform = 30000;
    mix.contribution = 30000;
    mix.bContribution = 1.8;
    mix.inefficiency = 1;
    MixtureDensity density(4);
    CounterRng rng(1);
    const auto pay = [&](double u) {
        const Toy t = toyAt(u);
        const double w = mix.uniformWeight(t.size);
        density.add(static_cast<size_t>(u * 4), w, w, t.shared);
    };
    for (int i = 0; i < 30000; ++i) pay(rng.nextDouble());
    // The contribution replica is in either part half of the time: 0.9 x 1 = 0.1 x 9.
    for (int i = 0; i < 30000; ++i)
        pay(rng.nextDouble() < 0.5 ? 0.9 * rng.nextDouble() : 0.9 + 0.1 * rng.nextDouble());
    density.endIteration();
    EXPECT_NEAR(density.ofShared() / (30000 + 30000 / 1.8), 1, 1e-9);  // 1 / W where something is shared
}

TEST(MixtureDensity, IsUnknownAtFirstAndForgets) {
    MixtureDensity density(1);
    EXPECT_EQ(density.ofShared(), 0);
    density.add(0, 1, 0.1, 1);
    density.endIteration();
    EXPECT_DOUBLE_EQ(density.ofShared(), 10);
    for (int i = 0; i < 100; ++i) {
        density.add(0, 1, 0.01, 1);
        density.endIteration();
    }
    EXPECT_NEAR(density.ofShared(), 100, 0.1);
}

}  // namespace
}  // namespace metrolux::core
