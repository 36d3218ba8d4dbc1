// What single operations cost (Google Benchmark): bench_kernels --benchmark_filter=Bsdf
#include "base/warp.h"
#include "integrators/iteration.h"
#include "markov/mutation.h"
#include "sampling/streams.h"
#include "scattering/phong.h"
#include "scattering/plastic.h"
#include "scattering/principled.h"
#include "scattering/rough_dielectric.h"
#include "scattering/rough_plastic.h"
#include "scattering/ward.h"
#include "support/small_scenes.h"
#include "transport/connect.h"
#include "transport/subpath.h"

#include <benchmark/benchmark.h>

namespace metrolux::core {
namespace {

struct Model {
    const char* name;
    BsdfPtr bsdf;
};

const std::vector<Model>& models() {
    static const std::vector<Model> all{{"diffuse", test::diffuse(0.5f)},
                                        {"dielectric", makeDielectric({})},
                                        {"rough_conductor", makeRoughConductor({})},
                                        {"rough_dielectric", makeRoughDielectric({})},
                                        {"plastic", makePlastic({})},
                                        {"rough_plastic", makeRoughPlastic({})},
                                        {"ward", makeWard({})},
                                        {"phong", makePhong({})},
                                        {"principled", makePrincipled({})}};
    return all;
}

SurfaceInteraction flat() {
    SurfaceInteraction si;
    si.ng = si.ns = Vec3f(0, 0, 1);
    si.s = Vec3f(1, 0, 0);
    return si;
}

/// Directions above the surface, the same for all models.
std::vector<Vec3f> directions() {
    std::vector<Vec3f> result;
    CounterRng rng(hashKey(1));
    for (int i = 0; i < 1024; ++i) result.push_back(warp::squareToCosineHemisphere(rng.next2D()));
    return result;
}

void sampleBsdf(benchmark::State& state, const Bsdf& bsdf) {
    const SurfaceInteraction si = flat();
    const std::vector<Vec3f> known = directions();
    CounterRng rng(hashKey(2));
    size_t i = 0;
    for (auto _ : state) {
        const float uLobe = rng.next1D();
        benchmark::DoNotOptimize(
            bsdf.sample(si, known[++i % known.size()], TransportMode::Radiance, uLobe, rng.next2D()));
    }
}

void evaluateBsdf(benchmark::State& state, const Bsdf& bsdf) {
    const SurfaceInteraction si = flat();
    const std::vector<Vec3f> w = directions();
    size_t i = 0;
    for (auto _ : state) {
        ++i;
        benchmark::DoNotOptimize(bsdf.evaluate(si, w[i % w.size()], w[(i * 7) % w.size()]));
    }
}

/// A floor under `count` small lamps, spread over it.
std::shared_ptr<Scene> lampScene(int count) {
    test::SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 50, 50), test::diffuse(0.5f));
    b.add(makeSphere(Transform(), {0, 1, 0}, 1, false), test::diffuse(0.7f));
    CounterRng rng(hashKey(3));
    for (int i = 0; i < count; ++i) {
        const Vec2f p = rng.next2D();
        const Vec3f center(100 * p.x - 50, 3, 100 * p.y - 50);
        b.emit(b.add(test::rectangle(center, {0, -1, 0}, 0.05f, 0.05f), test::diffuse(0)), Rgb(10));
    }
    b.camera({0, 4, 12}, {0, 1, 0}, 50, 64, 48);
    b.limits().maxDepth = 6;
    return b.build();
}

void chooseLight(benchmark::State& state) {
    const auto scene = lampScene(static_cast<int>(state.range(0)));
    CounterRng rng(hashKey(4));
    for (auto _ : state) {
        const Vec3f x(20 * rng.next1D() - 10, 0, 20 * rng.next1D() - 10);
        float u = rng.next1D();
        const Scene::LightChoice choice = scene->chooseLightForConnection(x, u);
        benchmark::DoNotOptimize(choice.light->connect(x, rng.next2D()));
    }
}

void lightDensity(benchmark::State& state) {
    const auto scene = lampScene(static_cast<int>(state.range(0)));
    CounterRng rng(hashKey(5));
    for (auto _ : state) {
        const Vec3f x(20 * rng.next1D() - 10, 0, 20 * rng.next1D() - 10);
        const auto i = static_cast<size_t>(rng.next1D() * static_cast<float>(scene->lights().size()));
        benchmark::DoNotOptimize(scene->connectionProbability(x, scene->lights()[i].get()));
    }
}

/// Vertices of eye subpaths of that scene, four for each pixel of a square image.
std::vector<Vertex> vertices(size_t count) {
    std::vector<Vertex> result(count);
    CounterRng rng(hashKey(6));
    for (Vertex& v : result) v.si.p = Vec3f(rng.next1D(), 0, rng.next1D());
    return result;
}
/// On average two vertices within reach.
float radiusFor(size_t count) { return std::sqrt(2 / (kPi * static_cast<float>(count))); }

void buildGrid(benchmark::State& state) {
    const std::vector<Vertex> v = vertices(static_cast<size_t>(state.range(0)));
    VertexGrid grid;
    for (auto _ : state) grid.build(positionsOf(v), radiusFor(v.size()));
    state.SetItemsProcessed(state.iterations() * state.range(0));
}

void queryGrid(benchmark::State& state) {
    const std::vector<Vertex> v = vertices(static_cast<size_t>(state.range(0)));
    VertexGrid grid;
    grid.build(positionsOf(v), radiusFor(v.size()));
    CounterRng rng(hashKey(7));
    uint64_t found = 0;
    for (auto _ : state) grid.query({rng.next1D(), 0, rng.next1D()}, [&](uint32_t index) { found += index; });
    benchmark::DoNotOptimize(found);
}

void splatFilm(benchmark::State& state) {
    FilmWindow window;
    Film film(window, {ReconstructionFilter::Kind::Gaussian, {}});
    SplatList splats;
    splats.film.resize(1);
    CounterRng rng(hashKey(8));
    for (auto _ : state) {
        const Vec2f u = rng.next2D();
        splats.film[0] = {{u.x * static_cast<float>(window.width), u.y * static_cast<float>(window.height)},
                          Rgb(1)};
        film.addSplats(splats, 1e-6);
    }
}

void mutate(benchmark::State& state, MutationKernel::Kind kind) {
    const MutationKernel kernel(kind);
    CounterRng rng(hashKey(9));
    PrimarySample from(32, 0.5f), to;
    for (auto _ : state) {
        kernel.mutate(from, to, rng);
        benchmark::DoNotOptimize(to.data());
    }
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(from.size()));
}

void drawPairs(benchmark::State& state, SampleStream&& stream) {
    for (auto _ : state) {
        stream.seek(1);
        benchmark::DoNotOptimize(stream.next2D());
    }
}
void drawSobol(benchmark::State& state) { drawPairs(state, SobolStream(1, 5)); }
void drawIndependent(benchmark::State& state) { drawPairs(state, IndependentStream(1)); }

/// Counts vertices.
class Counter final : public SubpathVisitor {
  public:
    int64_t vertices = 0;
    bool surface(const Vertex&) override {
        ++vertices;
        return true;
    }
};

template <bool kFromCamera>
void traceSubpath(benchmark::State& state) {
    const auto scene = lampScene(4);
    Counter counter;
    uint32_t i = 0;
    for (auto _ : state) {
        SobolStream stream(hashKey(10), ++i);
        if (kFromCamera)
            traceEyeSubpath(*scene, stream, scene->parts().limits, Strategies::path(),
                            Vec2f(static_cast<float>(i % 64), static_cast<float>(i / 64 % 48)), 1, 0,
                            counter);
        else
            traceLightSubpath(*scene, stream, scene->parts().limits, Strategies::path(), counter);
    }
    state.SetItemsProcessed(counter.vertices);
}

[[maybe_unused]] const bool registered = [] {
    for (const Model& m : models()) {
        benchmark::RegisterBenchmark((std::string("Bsdf/sample/") + m.name).c_str(),
                                     [&](benchmark::State& s) { sampleBsdf(s, *m.bsdf); });
        if (m.bsdf->hasSmoothLobe())
            benchmark::RegisterBenchmark((std::string("Bsdf/evaluate/") + m.name).c_str(),
                                         [&](benchmark::State& s) { evaluateBsdf(s, *m.bsdf); });
    }
    return true;
}();

BENCHMARK(chooseLight)->Name("Light/sample")->RangeMultiplier(10)->Range(1, 10000);
BENCHMARK(lightDensity)->Name("Light/density")->RangeMultiplier(10)->Range(1, 10000);
BENCHMARK(buildGrid)->Name("Grid/build")->RangeMultiplier(10)->Range(10000, 1000000);
BENCHMARK(queryGrid)->Name("Grid/query")->RangeMultiplier(10)->Range(10000, 1000000);
BENCHMARK(splatFilm)->Name("Film/splat");
BENCHMARK_CAPTURE(mutate, kelemen, MutationKernel::Kind::Kelemen)->Name("Mutation/kelemen");
BENCHMARK_CAPTURE(mutate, adaptive, MutationKernel::Kind::Adaptive)->Name("Mutation/adaptive");
BENCHMARK(drawSobol)->Name("Stream/sobol");
BENCHMARK(drawIndependent)->Name("Stream/independent");
BENCHMARK(traceSubpath<true>)->Name("Subpath/eye");
BENCHMARK(traceSubpath<false>)->Name("Subpath/light");

}  // namespace
}  // namespace metrolux::core
