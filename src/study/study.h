#pragma once
/// Compares integrators on one scene: each renders it with several seeds for the same time or number of
/// passes, and its error against a reference is followed.

#include "render/pass_loop.h"
#include "render/progress.h"
#include "study/curve.h"

#include <nlohmann/json.hpp>

#include <optional>

namespace metrolux::core::study {

/// One of the integrators that are compared, with its options.
struct Entrant {
    std::string label;                  ///< as the user wrote it: "mcmc_vcm:kernel=adaptive"
    std::string integrator;             ///< as for chooseIntegrator()
    ParameterValues parameters;         ///< in place of the scene's and of the defaults
    CommonOptions options;              ///< seed and limits are set for each run
    std::optional<int> maxDepth;        ///< in place of the scene's
    std::vector<std::string> settings;  ///< the command-line words that parameters and options came from
};

/// What "seconds" are.
enum class Clock {
    Wall,
    /// Processor time of the program over its threads: what the clock on the wall would show if nothing else
    /// ran and all threads were always busy. For machines that are shared.
    Processor
};

struct Plan {
    std::vector<Entrant> entrants;
    double seconds = 0;   ///< equal time; 0: equal passes
    uint32_t passes = 0;  ///< equal passes
    Clock clock = Clock::Wall;
    int threads = 1;  ///< that renders run on
    uint64_t firstSeed = 1;
    int seeds = 3;  ///< seeds firstSeed ... firstSeed + seeds - 1
    double epsilon = kRelMseEpsilon;

    Abscissa abscissa() const { return seconds > 0 ? Abscissa::Seconds : Abscissa::Passes; }
    std::vector<double> grid() const {
        return measuringGrid(abscissa(), seconds > 0 ? seconds : static_cast<double>(passes));
    }
};

struct Reference {
    ImageData image;
    std::string file;              ///< where it was read from; empty: rendered
    std::string integrator;        ///< label of the entrant that rendered it
    std::vector<uint64_t> seeds;   ///< of its two halves
    std::vector<uint32_t> passes;  ///< of its two halves
    double seconds = 0;            ///< of both, on the wall's clock
    /// Of a rendered one: what compareImages finds between it and an image that differs from it by its own
    /// noise (half the difference of its two halves). The bias is one draw of its noise.
    std::optional<ImageDifference> noise;
};

/// One integrator with one seed.
struct Run {
    uint64_t seed = 0;
    double setupSeconds = 0;  ///< construction of the integrator; counted as time of rendering
    StopReason reason = StopReason::Interrupted;
    uint64_t nonFinite = 0;  ///< contributions that were left out
    std::vector<Measurement> measurements;
    ImageData image;            ///< empty before the first pass
    nlohmann::json statistics;  ///< of the integrator

    bool complete() const { return reason != StopReason::Interrupted; }
};

/// What became of an entrant.
struct Contribution {
    std::vector<Run> runs;
    std::string refusal;  ///< why it cannot render this scene; empty: it can

    std::vector<std::vector<Measurement>> completeRuns() const;
};

struct SceneStudy {
    std::string name;  ///< of its folder
    std::string file;
    FilmWindow window;
    std::vector<std::string> warnings;  ///< of the loader
    Reference reference;
    std::vector<Contribution> contributions;  ///< one for each entrant of the plan
    bool interrupted = false;
};

/// What happens while a study runs.
struct Surroundings {
    std::function<bool()> interrupted = [] { return false; };
    ProgressReporter::Mode progress = ProgressReporter::Mode::Silent;
    /// After each run, with everything so far: `entrant` and its last run are new.
    std::function<void(const SceneStudy&, size_t entrant)> afterRun = [](const SceneStudy&, size_t) {};
};

/// Renders a reference for `seconds` as the mean of two independent halves of the same time, with the seeds
/// that follow those of the plan. Empty when it was interrupted before both had a pass. Throws Error when the
/// integrator refuses the scene.
std::optional<Reference> renderReference(const Scene& scene, const Plan& plan, const Entrant& entrant,
                                         double seconds, const Surroundings& surroundings);

/// Runs all entrants with the first seed, then all with the next one, so that a change in the machine's speed
/// meets them alike, and an interrupted study has whole rounds. `study` comes with everything but its
/// contributions. An integrator that refuses the scene is left out and says why.
void runStudy(const Scene& scene, const Plan& plan, SceneStudy& study, const Surroundings& surroundings);

/// Statistics over the complete runs of an entrant.
struct Summary {
    std::vector<CurvePoint> curve;
    PerMetric<std::vector<PowerLaw>> fits;  ///< a fit for each run
    PerMetric<Rate> rates;
    PerMetric<Interval> final;   ///< at the end, as in the curve
    Interval finalAbsoluteBias;  ///< arithmetic mean of |bias| over the seeds
    size_t runs = 0;             ///< complete ones; the rest means nothing without
};
Summary summarize(const Contribution& contribution, const Plan& plan);

/// The entrant with the smallest error at the end for each metric (logarithms of errors, |bias|).
PerMetric<Ranking> rank(const std::vector<Contribution>& contributions);

}  // namespace metrolux::core::study
