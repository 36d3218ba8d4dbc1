#include "study/study.h"

#include "base/clock.h"
#include "base/error.h"
#include "geometry/intersector.h"
#include "integrators/scene_choice.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <numeric>

namespace metrolux::core::study {
namespace {

/// A clock that can be stopped while something is done that is not to be counted.
class Stopwatch {
  public:
    /// `threads`: for Clock::Processor.
    explicit Stopwatch(Clock clock = Clock::Wall, int threads = 1)
        : clock_(clock), threads_(threads), start_(now()) {}

    double seconds() const { return now() - start_ - paused_; }
    template <class Body>
    void pauseFor(Body&& body) {
        const double before = now();
        body();
        paused_ += now() - before;
    }

  private:
    double now() const { return clock_ == Clock::Wall ? steadySeconds() : processorSeconds() / threads_; }

    Clock clock_;
    int threads_;
    double start_, paused_ = 0;
};

CommonOptions optionsFor(const Scene& scene, const Entrant& entrant, uint64_t seed) {
    CommonOptions options = entrant.options;
    options.seed = seed;
    options.limits = scene.parts().limits;
    if (entrant.maxDepth) options.limits.maxDepth = *entrant.maxDepth;
    return options;
}

ImageData imageOf(const Film& film) {
    if (film.passes() == 0) return {};
    return {film.width(), film.height(), 3, film.image()};
}

/// Renders with one seed. The construction of the integrator counts as rendering: some sample there.
/// `measure` is called after each pass with its report, off the clock.
Run render(const Scene& scene, const Entrant& entrant, uint64_t seed, RenderLimits limits, Stopwatch watch,
           const Surroundings& surroundings,
           const std::function<void(const Film&, const PassReport&)>& measure) {
    Run run;
    run.seed = seed;
    Film film = makeFilm(scene);
    ProgressReporter progress(surroundings.progress);
    const IntegratorChoice choice =
        chooseIntegrator(entrant.integrator, scene.parts().integrator, entrant.parameters);
    const auto integrator =
        choice.integrator->prepare(scene, optionsFor(scene, entrant, seed), choice.parameters)(seed);
    run.setupSeconds = watch.seconds();
    if (limits.seconds > 0) limits.seconds = std::max(limits.seconds - run.setupSeconds, 1e-9);
    const RayStatistics before = Intersector::statistics();
    PassLoopHooks hooks;
    hooks.clock = [&] { return watch.seconds(); };
    hooks.interrupted = surroundings.interrupted;
    hooks.afterPass = [&](PassReport report) {
        watch.pauseFor([&] {
            const RayStatistics rays = Intersector::statistics() - before;
            progress.update(report, static_cast<double>(rays.all()) / report.seconds, entrant.label);
            report.seconds += run.setupSeconds;
            measure(film, report);
        });
    };
    run.reason = renderPasses(*integrator, film, limits, hooks);
    progress.finish();
    run.image = imageOf(film);
    const TechniqueCounts nonFinite = integrator->nonFinite();
    run.nonFinite = std::accumulate(nonFinite.begin(), nonFinite.end(), uint64_t{0});
    run.statistics = integrator->statistics();
    return run;
}

/// Renders and compares with the reference as the grid says, and at the end.
Run measuredRun(const Scene& scene, const Plan& plan, const Entrant& entrant, uint64_t seed,
                const ImageData& reference, const Surroundings& surroundings) {
    MeasuringSchedule schedule(plan.grid());
    std::vector<Measurement> measurements;
    const auto take = [&](const ImageData& image, const PassReport& report) {
        measurements.push_back(
            {report.passes, report.seconds, metricValues(compareImages(image, reference, plan.epsilon))});
    };
    PassReport last;
    RenderLimits limits;
    limits.seconds = plan.seconds;
    limits.passes = plan.passes;
    Run run =
        render(scene, entrant, seed, limits, Stopwatch(plan.clock, plan.threads), surroundings,
               [&](const Film& film, const PassReport& report) {
                   last = report;
                   if (schedule.due(plan.abscissa() == Abscissa::Seconds ? report.seconds : report.passes))
                       take(imageOf(film), report);
               });
    if (last.passes > 0 && measurements.back().passes < last.passes) take(run.image, last);
    run.measurements = std::move(measurements);
    return run;
}

ImageData combined(const ImageData& a, const ImageData& b, float weightA, float weightB) {
    ImageData result = a;
    for (size_t i = 0; i < result.pixels.size(); ++i)
        result.pixels[i] = weightA * a.pixels[i] + weightB * b.pixels[i];
    return result;
}

void logRun(const Plan& plan, const Entrant& entrant, const Run& run) {
    if (run.measurements.empty()) return;
    const Measurement& m = run.measurements.back();
    spdlog::info("{}, seed {} of {}: {}, {} passes, relMSE {:.4g}, bias {:+.3g} %{}", entrant.label,
                 run.seed - plan.firstSeed + 1, plan.seeds, durationText(m.seconds), m.passes,
                 m.values[indexOf(Metric::RelMse)], 100 * m.values[indexOf(Metric::Bias)],
                 run.complete() ? "" : ", interrupted");
    if (run.nonFinite > 0)
        spdlog::warn("{}: {} contributions were not finite and were left out", entrant.label, run.nonFinite);
}

}  // namespace

std::vector<std::vector<Measurement>> Contribution::completeRuns() const {
    std::vector<std::vector<Measurement>> result;
    for (const Run& run : runs)
        if (run.complete()) result.push_back(run.measurements);
    return result;
}

std::optional<Reference> renderReference(const Scene& scene, const Plan& plan, const Entrant& entrant,
                                         double seconds, const Surroundings& surroundings) {
    Reference reference;
    reference.integrator = entrant.label;
    std::vector<ImageData> halves;
    for (int half = 0; half < 2; ++half) {
        const uint64_t seed = plan.firstSeed + static_cast<uint64_t>(plan.seeds + half);
        RenderLimits limits;
        limits.seconds = seconds / 2;
        PassReport last;
        Run run = render(scene, entrant, seed, limits, Stopwatch(), surroundings,
                         [&](const Film&, const PassReport& report) { last = report; });
        if (last.passes == 0) return std::nullopt;
        reference.seeds.push_back(seed);
        reference.passes.push_back(last.passes);
        reference.seconds += last.seconds;
        halves.push_back(std::move(run.image));
    }
    reference.image = combined(halves[0], halves[1], 0.5f, 0.5f);
    reference.noise = compareImages(halves[0], reference.image, plan.epsilon);
    return reference;
}

void runStudy(const Scene& scene, const Plan& plan, SceneStudy& study, const Surroundings& surroundings) {
    study.contributions.assign(plan.entrants.size(), {});
    for (int k = 0; k < plan.seeds; ++k) {
        for (size_t e = 0; e < plan.entrants.size(); ++e) {
            Contribution& contribution = study.contributions[e];
            const Entrant& entrant = plan.entrants[e];
            if (!contribution.refusal.empty()) continue;
            try {
                contribution.runs.push_back(measuredRun(scene, plan, entrant,
                                                        plan.firstSeed + static_cast<uint64_t>(k),
                                                        study.reference.image, surroundings));
            } catch (const Error& error) {
                contribution.refusal = error.what();
                spdlog::warn("{} is left out: {}", entrant.label, error.what());
                continue;
            }
            study.interrupted = !contribution.runs.back().complete();
            logRun(plan, entrant, contribution.runs.back());
            surroundings.afterRun(study, e);
            if (study.interrupted) return;
        }
    }
}

Summary summarize(const Contribution& contribution, const Plan& plan) {
    Summary summary;
    const auto runs = contribution.completeRuns();
    summary.runs = runs.size();
    if (runs.empty()) return summary;
    summary.curve = summarize(runs, plan.abscissa(), plan.grid());
    summary.final = summary.curve.back().values;
    for (Metric metric : kMetrics) {
        const size_t i = indexOf(metric);
        for (const auto& run : runs) summary.fits[i].push_back(fitRun(run, metric));
        summary.rates[i] = convergenceRate(summary.fits[i]);
    }
    std::vector<double> sizes;
    sizes.reserve(runs.size());
    for (const auto& run : runs) sizes.push_back(std::abs(run.back().values[indexOf(Metric::Bias)]));
    summary.finalAbsoluteBias = meanInterval(sizes);
    return summary;
}

PerMetric<Ranking> rank(const std::vector<Contribution>& contributions) {
    PerMetric<Ranking> result;
    for (Metric metric : kMetrics) {
        std::vector<std::vector<double>> samples(contributions.size());
        for (size_t e = 0; e < contributions.size(); ++e) {
            for (const auto& run : contributions[e].completeRuns()) {
                const double value = run.back().values[indexOf(metric)];
                samples[e].push_back(metric == Metric::Bias ? std::abs(value) : std::log(value));
            }
        }
        result[indexOf(metric)] = rankSmallest(samples);
    }
    return result;
}

}  // namespace metrolux::core::study
