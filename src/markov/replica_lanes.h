#pragma once
/// The replicas of docs/explain/algorithm.md section 3 (uniform, visibility, contribution) in independent
/// lanes, with replica exchange and expected-value weights. Like the chains, it knows nothing of what a value
/// means.
///
/// A lane (replica_lane.h) is one set of the replicas. How many samples each takes and when is the schedule
/// (replica_schedule.h); what waits for the chains and what they start from is the pool (replica_pool.h).

#include "base/parallel.h"
#include "markov/replica_lane.h"
#include "markov/replica_schedule.h"

#include <tbb/task_arena.h>

namespace metrolux::core {

/// A fixed number of lanes, each with its own chains, adaptation and random numbers, that live across
/// iterations. `Value` has `double size` (F), `bool visible() const`, and may have `double squares`, the
/// noise that it brings, for the measured split (F^2 without). A `Model` joins them with transport:
///
///     void startUniform(PrimarySample& u, CounterRng&, size_t lane, size_t sample)
///     void evaluateUniform(std::span<const Evaluation<Value>>)
///     void evaluate(std::span<const Evaluation<Value>>)
///     void pay(size_t lane, Value&, double weight)
///
/// startUniform() appends coordinates to begin with, to the lane's uniform sample of that number; pay() adds
/// what the value contributes, with its weight. Its calls come from many threads, those of a lane from one.
/// evaluateUniform() gets samples of one lane, evaluate() proposals of as many lanes as are run together,
/// which depends on the number of threads: what it makes of a stream must not depend on the others.
template <class Value>
class ReplicaLanes {
  public:
    explicit ReplicaLanes(const ReplicaSettings& settings)
        : settings_(settings), normalization_(settings.normalization), split_(settings.splitInUse()) {
        for (int i = 0; i < settings.lanes; ++i)
            lanes_.emplace_back(settings, i, normalization_.newSamples());
    }

    const ReplicaSettings& settings() const { return settings_; }
    size_t size() const { return lanes_.size(); }
    Normalization& normalization() { return normalization_; }
    const Normalization& normalization() const { return normalization_; }

    /// Counts and normalizations of an iteration of about so many samples; each lane takes its part of every
    /// replica in use. Without `chains`: uniform samples alone.
    ReplicaMixture mixture(size_t samples, bool chains = true) const {
        ReplicaMixture mix;
        mix.bVisibility = normalization_.visibility();
        mix.bContribution = normalization_.contribution();
        mix.inefficiency = settings_.inefficiency;
        const std::array<double, 3> parts = chains ? split() : std::array<double, 3>{1, 0, 0},
                                    counts = replicaSamples(parts, samples, lanes_.size());
        mix.uniform = counts[0];
        mix.visibility = counts[1];
        mix.contribution = counts[2];
        return mix;
    }

    /// Parts of the replicas in the next iteration's samples.
    const std::array<double, 3>& split() const { return split_.split(); }

    /// Samples of an iteration that were taken elsewhere, uniform ones of these sizes. Shared out among the
    /// lanes, so that the jackknife over lanes covers them.
    void addUniform(const std::vector<double>& sizes) {
        for (size_t i = 0; i < sizes.size(); ++i) lanes_[i % lanes_.size()].samples().addUniform(sizes[i]);
    }

    /// All samples of an iteration; the scales of `mix` are set. `pass` and `first` name the iteration.
    template <class Model>
    void run(Model& model, ReplicaMixture& mix, uint32_t pass, size_t first) {
        for (Lane& lane : lanes_) lane.begin();
        const ReplicaSchedule schedule(mix, lanes_.size());
        // Chains that run without the uniform replica (a study of each alone) start from uniform samples too,
        // which then contribute nothing themselves.
        const size_t most = mix.uniform > 0 ? schedule.uniformSamples() : schedule.steps();
        const size_t drawn = drawPool(model, mix, most);
        CounterRng rng(hashKey(settings_.seed, StreamPurpose::Replacement, pass, first));
        sawChains_ = startChains(mix, double(drawn * lanes_.size()), rng);
        if (!sawChains_) return;  // no uniform sample is visible, and all have been paid
        // Lanes of a group take turns at each step, so that their proposals are evaluated side by side.
        const auto threads = static_cast<size_t>(tbb::this_task_arena::max_concurrency());
        const size_t group =
            std::clamp<size_t>(lanes_.size() / (kGroupsPerThread * threads), 1, kLargestGroup);
        parallelFor((lanes_.size() + group - 1) / group, [&](size_t i) {
            const size_t begin = i * group, end = std::min(lanes_.size(), begin + group);
            runLanes(model, {lanes_.data() + begin, end - begin}, mix, schedule);
        });
    }

    /// Closes the iteration, made with this squared radius.
    void endIteration(double squaredRadius) {
        for (size_t i = 0; i < lanes_.size(); ++i) {
            normalization_.add(static_cast<int>(i), lanes_[i].samples());
            lanes_[i].samples().clear();
        }
        normalization_.endIteration(squaredRadius);
        if (settings_.pooledTheta) shareTheta();
        if (settings_.measuredSplit && sawChains_) {
            for (const Lane& lane : lanes_) split_.add(lane.squares());
            split_.endIteration(settings_.inefficiency);
        }
        sawChains_ = false;
    }

    /// Between two iterations, when all weights have been paid. Values are evaluated again by run().
    template <class Archive>
    void serialize(Archive& archive) {
        serializeElements(archive, lanes_, "lanes");
        archive(normalization_, split_);
    }

    ReplicaCounts counts() const {
        ReplicaCounts counts;
        for (const Lane& lane : lanes_) lane.addTo(counts, lanes_.size());
        return counts;
    }

  private:
    using Lane = ReplicaLane<Value>;

    /// Visible states that an iteration's chains are chosen from, at most. Their mean F enters the image as a
    /// factor.
    static constexpr size_t kPoolSize = 16384;
    /// More groups than threads, because they are never equally fast.
    static constexpr size_t kGroupsPerThread = 4, kLargestGroup = 8;

    void shareTheta() {
        std::vector<MutationKernel*> visibility, contribution;
        for (Lane& lane : lanes_) {
            visibility.push_back(&lane.visibilityKernel());
            contribution.push_back(&lane.contributionKernel());
        }
        MutationKernel::shareTheta(visibility);
        MutationKernel::shareTheta(contribution);
    }

    /// Takes the first of the iteration's uniform samples, `most` in a lane, until enough are visible to
    /// start the chains from. Returns how many a lane has taken.
    template <class Model>
    size_t drawPool(Model& model, const ReplicaMixture& mix, size_t most) {
        size_t drawn = 0, visible = 0;
        const size_t round = std::max<size_t>(1, kPoolSize / lanes_.size());
        while (drawn < most && visible < kPoolSize) {
            drawn = std::min(most, drawn + round);
            parallelFor(lanes_.size(), [&](size_t i) { lanes_[i].addUniform(model, mix, drawn); });
            visible = 0;
            for (const Lane& lane : lanes_) visible += lane.uniform().visible();
        }
        return drawn;
    }

    /// The targets are new in each iteration. Chains start from visible uniform samples of this iteration:
    /// any of them for the visibility replica, chosen in proportion to F for the contribution replica, with
    /// the scales that make such a start unbiased (ReplicaMixture), however few are visible: where one
    /// iteration in ten has a visible sample, its chains count ten times. False if there is none; then what
    /// chains would find counts 0 times. Going on from the last iteration's states made short chains up to
    /// 9 % too bright (white sphere in glass, 32x32 pixels), and lost half of the light, more with every
    /// pass, where hardly a state stays visible (vpt of a plane with a small radius). The same start without
    /// the scales made them 1.2 % too dark where F has heavy tails (veach-mis, 64x48).
    bool startChains(ReplicaMixture& mix, double drawn, CounterRng& rng) {
        ReplicaPool<Value> pool;
        for (const Lane& lane : lanes_) pool.add(lane.uniform());
        mix.visibilityScale = pool.visible() / (drawn * mix.bVisibility);
        mix.contributionScale = pool.sumOfSizes() / (drawn * mix.bContribution);
        if (pool.empty()) return false;
        const auto forVisibility = pool.draw(lanes_.size(), rng.nextDouble());
        const auto forContribution = pool.drawBySize(lanes_.size(), rng.nextDouble());
        for (size_t i = 0; i < lanes_.size(); ++i) lanes_[i].start(*forVisibility[i], *forContribution[i]);
        return true;
    }

    template <class Model>
    static void runLanes(Model& model, std::span<Lane> lanes, const ReplicaMixture& mix,
                         const ReplicaSchedule& schedule) {
        const size_t steps = schedule.steps();
        std::vector<Evaluation<Value>> proposals;
        for (size_t step = 0; step < steps; ++step) {
            const ReplicaSchedule::Due due = schedule.at(step);
            proposals.clear();
            for (Lane& lane : lanes) {
                if (due.uniform) lane.uniformStep(model, mix, schedule.uniformSamples(), due.visibility);
                lane.propose(due.visibility, due.contribution, proposals);
            }
            model.evaluate(std::span<const Evaluation<Value>>(proposals));
            for (Lane& lane : lanes) {
                if (due.visibility) lane.visibilityStep(model, mix);
                if (due.contribution) lane.contributionStep(model, mix);
            }
        }
        for (Lane& lane : lanes) lane.finish(model);
    }

    ReplicaSettings settings_;
    std::vector<Lane> lanes_;
    Normalization normalization_;
    SplitEstimator split_;
    bool sawChains_ = false;  ///< chains have run in this iteration
};

}  // namespace metrolux::core
