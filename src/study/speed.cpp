#include "study/speed.h"

#include "base/clock.h"
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "geometry/ray_replay.h"
#include "integrators/iteration.h"
#include "render/threads.h"
#include "transport/light_subpath_pass.h"

#include <fmt/format.h>

#include <map>
#include <numbers>

namespace metrolux::core::study {
namespace {

/// Seconds by the clock on the wall, and of all threads of the process.
struct Lap {
    double wall = 0, cpu = 0;
};

template <class Body>
Lap measure(Body&& body) {
    const double wall = steadySeconds(), cpu = processorSeconds();
    body();
    return {steadySeconds() - wall, processorSeconds() - cpu};
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    const size_t n = values.size();
    return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

std::vector<double> column(const std::vector<Lap>& laps, double Lap::*member) {
    std::vector<double> result;
    for (const Lap& lap : laps) result.push_back(lap.*member);
    return result;
}

std::vector<double> ratios(const std::vector<Lap>& a, const std::vector<Lap>& b, double Lap::*member) {
    std::vector<double> result;
    for (size_t i = 0; i < a.size(); ++i) result.push_back(a[i].*member / b[i].*member);
    return result;
}

/// An integrator with a film of its own. Two of them do the same work in the same pass.
struct Renderer {
    Film film;
    std::unique_ptr<Integrator> integrator;

    Renderer(const Scene& scene, const SpeedOptions& o)
        : film(makeFilm(scene)),
          integrator(o.choice.integrator->prepare(scene, o.options, o.choice.parameters)(o.options.seed)) {}

    Lap pass(int threads) {
        ThreadLimit limit(threads);
        return measure([&] { limit.execute([&] { integrator->renderPass(film, film.passes()); }); });
    }
};

struct RayCount {
    uint64_t intersect = 0, occlusion = 0, hits = 0;
    uint64_t total() const { return intersect + occlusion; }
    void add(std::span<const RecordedRay> rays) {
        for (const RecordedRay& r : rays) {
            (r.occlusion ? occlusion : intersect) += 1;
            hits += !r.occlusion && r.hit;
        }
    }
};

RayCount countOf(const RayRecorder& recorder) {
    RayCount count;
    for (const RecordedThread* thread : recorder.byThread()) count.add(thread->rays);
    return count;
}

/// Replays what was recorded.
Lap replay(RayReplay& rays, int threads) {
    ThreadLimit limit(threads);
    const Lap lap = measure([&] { limit.execute([&] { rays.run(); }); });
    if (rays.different() > 0)
        throw std::logic_error(fmt::format("{} replayed rays got another answer", rays.different()));
    return lap;
}

/// A number of threads: its passes, and the replays of their rays.
struct Way {
    int threads;
    Renderer renderer;
    std::vector<Lap> passes, replays, sortedReplays;

    Way(int t, const Scene& scene, const SpeedOptions& o) : threads(t), renderer(scene, o) {}

    nlohmann::json toJson(double rays) const {
        const double seconds = median(column(passes, &Lap::wall));
        return {{"threads", threads},
                {"seconds_per_pass", seconds},
                {"cpu_seconds_per_pass", median(column(passes, &Lap::cpu))},
                {"replay_seconds", median(column(replays, &Lap::wall))},
                {"replay_cpu_seconds", median(column(replays, &Lap::cpu))},
                {"sorted_replay_seconds", median(column(sortedReplays, &Lap::wall))},
                {"sorted_replay_cpu_seconds", median(column(sortedReplays, &Lap::cpu))},
                {"rays_per_second", rays / seconds},
                {"ray_efficiency", median(ratios(replays, passes, &Lap::wall))},
                {"ray_efficiency_cpu", median(ratios(replays, passes, &Lap::cpu))},
                {"sorted_ray_efficiency", median(ratios(sortedReplays, passes, &Lap::wall))},
                {"sorted_ray_efficiency_cpu", median(ratios(sortedReplays, passes, &Lap::cpu))}};
    }
};

}  // namespace

nlohmann::json measurePasses(const Scene& scene, const SpeedOptions& o) {
    std::vector<std::unique_ptr<Way>> ways;
    ways.push_back(std::make_unique<Way>(o.threads, scene, o));
    for (uint32_t i = 0; i < o.warmUp; ++i) ways[0]->renderer.pass(o.threads);
    const uint64_t peak = peakMemoryBytes();  // of one renderer, before anything is recorded
    if (o.threads > 1) {
        ways.push_back(std::make_unique<Way>(1, scene, o));
        for (uint32_t i = 0; i < o.warmUp; ++i) ways[1]->renderer.pass(o.threads);
    }
    Renderer recorded(scene, o);
    for (uint32_t i = 0; i < o.warmUp; ++i) recorded.pass(o.threads);

    std::vector<double> intersect, occlusion, vertices;
    RayRecorder recorder;
    for (uint32_t i = 0; i < o.passes; ++i) {
        recorder.record([&] { recorded.pass(o.threads); });
        const RayCount rays = countOf(recorder);
        intersect.push_back(double(rays.intersect));
        occlusion.push_back(double(rays.occlusion));
        vertices.push_back(double(rays.hits));
        RayReplay asCalled(scene.intersector(), recorder, RayReplay::Order::AsCalled);
        RayReplay sorted(scene.intersector(), recorder, RayReplay::Order::Sorted);
        for (auto& way : ways) {
            way->passes.push_back(way->renderer.pass(way->threads));
            way->replays.push_back(replay(asCalled, way->threads));
            way->sortedReplays.push_back(replay(sorted, way->threads));
        }
    }

    const double rays = median(intersect) + median(occlusion);
    nlohmann::json j{{"integrator", o.choice.name()},
                     {"passes", o.passes},
                     {"pixels", recorded.film.pixelCount()},
                     {"rays_per_pass", {{"intersect", median(intersect)}, {"occlusion", median(occlusion)}}},
                     {"vertices_per_pass", median(vertices)},
                     {"peak_memory_bytes", peak},
                     {"ways", nlohmann::json::array()}};
    for (const auto& way : ways) j["ways"].push_back(way->toJson(rays));
    j["ray_efficiency"] = j["ways"][0]["ray_efficiency"];
    j["nanoseconds_per_vertex"] = 1e9 * median(column(ways[0]->passes, &Lap::cpu)) / median(vertices);
    if (ways.size() > 1) {
        j["speedup"] = median(ratios(ways[1]->passes, ways[0]->passes, &Lap::wall));
        // What is left of the speed of a thread when all work: the speedup of a machine without other load,
        // if no thread ever waits.
        j["speedup_cpu"] = o.threads * median(ratios(ways[1]->passes, ways[0]->passes, &Lap::cpu));
    }
    return j;
}

namespace {

/// The first merging radius of the integrator, or what it is by default where it has none.
double radiusOf(const Scene& scene, const SpeedOptions& o) {
    MergingParameters merging;
    if (o.choice.parameters.find("radius")) merging = o.choice.parameters.as<MergingParameters>();
    merging.resolve(scene, o.options.limits);
    return merging.radius;
}

/// Eye and light passes of vcm with techniques left out: differences of their times are what these cost.
class TechniqueBench {
  public:
    TechniqueBench(const Scene& scene, const SpeedOptions& o)
        : scene_(scene),
          o_(o),
          film_(makeFilm(scene)),
          radius_(radiusOf(scene, o)),
          pixels_(hilbertOrder(film_.width(), film_.height())),
          photons_(kPhotonCell * radius_) {
        const double n = double(pixels_.size());
        strategies_ = Strategies::bidirectional(1, n * std::numbers::pi * radius_ * radius_, &photons_);
        eyePass(true, eyes_);
        grid_.build(positionsOf(eyes_.all()), static_cast<float>(radius_));
    }

    Lap eye(bool nee) {
        return timed([&] { eyePass(nee, scratch_); });
    }
    Lap gridBuild() {
        return timed([&] { grid_.build(positionsOf(eyes_.all()), static_cast<float>(radius_)); });
    }
    Lap light(bool splat, bool connect, bool merge, TechniqueWork* work = nullptr) {
        Strategies strategies = strategies_;
        if (!splat) strategies.splat = 0;
        if (!connect) strategies.connect = 0;
        if (!merge) strategies.merge = 0;
        LightSubpathPass pass{scene_, o_.options.limits, strategies, eyes_, grid_, nonFinite_};
        pass.work = work;
        return timed([&] { independentLightSubpaths(pass, film_, o_.options.seed, {0, 0, pixels_.size()}); });
    }
    size_t storedVertices() const { return eyes_.all().size(); }
    double radius() const { return radius_; }

  private:
    void eyePass(bool nee, EyeVertices& result) {
        Strategies strategies = strategies_;
        if (!nee) strategies.nee = 0;
        wavefronts_.run({scene_, o_.options.limits, strategies, nonFinite_, o_.options.seed, 0}, pixels_,
                        film_, result);
    }
    template <class Body>
    Lap timed(Body&& body) {
        ThreadLimit limit(o_.threads);
        return measure([&] { limit.execute(body); });
    }

    const Scene& scene_;
    SpeedOptions o_;
    Film film_;
    NonFiniteCounts nonFinite_;
    double radius_;
    std::vector<uint32_t> pixels_;
    PhotonDensity photons_;
    Strategies strategies_;
    EyeVertices eyes_, scratch_;  ///< scratch_ keeps its memory, as an integrator does
    VertexGrid grid_;
    EyeWavefronts wavefronts_;
};

}  // namespace

nlohmann::json measureTechniques(const Scene& scene, const SpeedOptions& o) {
    TechniqueBench bench(scene, o);
    TechniqueWork work;
    RayRecorder recorder;
    recorder.record([&] { bench.eye(false); });
    const double eyeVertices = double(countOf(recorder).hits);
    recorder.record([&] { bench.light(false, false, false); });
    const double lightVertices = double(countOf(recorder).hits);
    bench.light(true, true, true, &work);

    std::map<std::string, std::vector<double>> seconds;
    for (uint32_t i = 0; i < o.passes; ++i) {
        const double eye = bench.eye(false).cpu, light = bench.light(false, false, false).cpu;
        seconds["eye_vertex"].push_back(eye);
        seconds["next_event"].push_back(bench.eye(true).cpu - eye);
        seconds["grid_build"].push_back(bench.gridBuild().cpu);
        seconds["light_vertex"].push_back(light);
        seconds["splat"].push_back(bench.light(true, false, false).cpu - light);
        seconds["connection"].push_back(bench.light(false, true, false).cpu - light);
        seconds["merge"].push_back(bench.light(false, false, true).cpu - light);
    }
    const double stored = double(bench.storedVertices());
    const std::map<std::string, double> counts{
        {"eye_vertex", eyeVertices},    {"next_event", stored},
        {"grid_build", stored},         {"light_vertex", lightVertices},
        {"splat", double(work.splats)}, {"connection", double(work.connections)},
        {"merge", double(work.merges)}};
    nlohmann::json j;
    for (const auto& [name, count] : counts) {
        j[name] = {{"count", count}};
        if (count > 0) j[name]["nanoseconds"] = 1e9 * median(seconds[name]) / count;
    }
    j["merge"]["searches"] = work.splats.load();
    return j;
}

std::string speedTable(const nlohmann::json& passes, const nlohmann::json& techniques) {
    std::string text = fmt::format("{:>8} {:>10} {:>10} {:>12} {:>15} {:>12}\n", "threads", "s/pass",
                                   "CPU s/pass", "Mrays/s", "ray efficiency", "rays sorted");
    for (const auto& way : passes["ways"])
        text +=
            fmt::format("{:8} {:10.4f} {:10.4f} {:12.3f} {:15.3f} {:12.3f}\n", way["threads"].get<int>(),
                        way["seconds_per_pass"].get<double>(), way["cpu_seconds_per_pass"].get<double>(),
                        1e-6 * way["rays_per_second"].get<double>(), way["ray_efficiency_cpu"].get<double>(),
                        way["sorted_ray_efficiency_cpu"].get<double>());
    if (passes.contains("speedup"))
        text += fmt::format("speedup {:.2f} (by CPU time {:.2f})\n", passes["speedup"].get<double>(),
                            passes["speedup_cpu"].get<double>());
    text += fmt::format("{:.0f} ns of a thread per path vertex, peak memory {:.0f} MB\n",
                        passes["nanoseconds_per_vertex"].get<double>(),
                        1e-6 * passes["peak_memory_bytes"].get<double>());
    text += fmt::format("{:>14} {:>12} {:>8}\n", "vcm", "in a pass", "ns each");
    for (const auto& [name, t] : techniques.items())
        if (t.contains("nanoseconds"))
            text += fmt::format("{:>14} {:12.0f} {:8.0f}\n", name, t["count"].get<double>(),
                                t["nanoseconds"].get<double>());
    return text;
}

}  // namespace metrolux::core::study
