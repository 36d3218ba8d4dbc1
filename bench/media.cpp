// What rays through grids cost: bench_kernels --benchmark_filter=Medium
#include "base/rng.h"
#include "base/warp.h"
#include "media/grid_volume.h"
#include "media/medium.h"

#include <benchmark/benchmark.h>
#include <string>
#include <vector>

namespace metrolux::core {
namespace {

struct Kind {
    const char* name;
    bool isBall;  ///< empty but for a ball that has a ninth of the cube
    GridFilter filter;
    int channels;
};
constexpr Kind kKinds[] = {{"full", false, GridFilter::Trilinear, 1},
                           {"full_rgb", false, GridFilter::Trilinear, 3},
                           {"full_nearest", false, GridFilter::Nearest, 1},
                           {"ball", true, GridFilter::Trilinear, 1}};

/// Of random samples.
MediumPtr gridMedium(const Kind& kind, int resolution) {
    GridSamples samples;
    samples.resolution = Imath::V3i(resolution);
    samples.channels = kind.channels;
    CounterRng rng(hashKey(3));
    const auto from = [&](int i) {
        return (static_cast<float>(i) + 0.5f) / static_cast<float>(resolution) - 0.5f;
    };
    for (int z = 0; z < resolution; ++z)
        for (int y = 0; y < resolution; ++y)
            for (int x = 0; x < resolution; ++x) {
                const bool isEmpty = kind.isBall && Vec3f(from(x), from(y), from(z)).length() > 0.3f;
                for (int c = 0; c < kind.channels; ++c) samples.values.push_back(isEmpty ? 0 : rng.next1D());
            }
    return makeHeterogeneousMedium(makeGridVolume(std::move(samples), {.filter = kind.filter}), 10,
                                   makeConstantVolume(Rgb(0.5f)), makeIsotropicPhase());
}

/// From all sides to points of the cube.
std::vector<Ray> rays() {
    std::vector<Ray> result;
    CounterRng rng(hashKey(4));
    for (int i = 0; i < 4096; ++i) {
        Ray ray;
        const Vec2f u = rng.next2D(), v = rng.next2D();
        ray.origin = Vec3f(0.5f) + warp::squareToSphere(u) * 2.0f;
        ray.direction = normalize(Vec3f(v.x, v.y, rng.next1D()) - ray.origin);
        result.push_back(ray);
    }
    return result;
}

void thickness(benchmark::State& state, const Kind& kind) {
    const MediumPtr medium = gridMedium(kind, static_cast<int>(state.range(0)));
    const std::vector<Ray> all = rays();
    size_t i = 0;
    for (auto _ : state) {
        const Ray& ray = all[i++ % all.size()];
        benchmark::DoNotOptimize(medium->thickness(ray.origin, ray.direction, kInfinity));
    }
}

void fly(benchmark::State& state, const Kind& kind) {
    const MediumPtr medium = gridMedium(kind, static_cast<int>(state.range(0)));
    const std::vector<Ray> all = rays();
    CounterRng rng(hashKey(5));
    size_t i = 0;
    for (auto _ : state) {
        const Ray& ray = all[i++ % all.size()];
        const float target = -std::log1p(-rng.next1D());
        benchmark::DoNotOptimize(medium->fly(ray.origin, ray.direction, kInfinity, 0, target));
    }
}

[[maybe_unused]] const bool registered = [] {
    for (const Kind& kind : kKinds) {
        const std::string name = kind.name;
        benchmark::RegisterBenchmark(("Medium/thickness/" + name).c_str(), thickness, kind)
            ->Arg(64)
            ->Arg(256);
        benchmark::RegisterBenchmark(("Medium/fly/" + name).c_str(), fly, kind)->Arg(64)->Arg(256);
    }
    return true;
}();

}  // namespace
}  // namespace metrolux::core
