/// RenderSession together with other processes. Each renders slices into its own film; now and then all
/// meet, and rank 0 receives the sum.

#include "base/clock.h"
#include "base/error.h"
#include "render/session.h"

#include <map>

namespace metrolux::core {
namespace {

/// Time between two meetings: what is written next decides.
double meetingInterval(const RunOptions& options) {
    double interval = kInfinity;
    if (options.saveEvery > 0) interval = options.saveEvery;
    if (!options.checkpoint.file.empty()) interval = std::min(interval, options.checkpoint.every);
    return interval;
}

}  // namespace

/// With a number of passes, a rank takes the next slice when it has finished one. Without, time is the
/// limit, and each rank keeps its own slices, in turns.
void RenderSession::shareSlices(Team& team, const RenderLimits& limits) {
    const SliceChoice& choice = options_.slices;
    if (limits.passes > 0) {
        integrator_.setNext([&]() -> std::optional<uint32_t> {
            while (true) {
                const uint64_t slice = uint64_t{choice.first} + team.takeNumber();
                if (slice > choice.last) return std::nullopt;
                if (integrator_.unfinished(static_cast<uint32_t>(slice))) return static_cast<uint32_t>(slice);
            }
        });
        return;
    }
    const auto size = static_cast<uint32_t>(team.size()),
               first = choice.first + static_cast<uint32_t>(team.rank());
    integrator_.setNext([=, next = first, last = choice.last]() mutable -> std::optional<uint32_t> {
        if (first > last) return std::nullopt;
        const uint32_t slice = next;
        next = slice + size > last ? first : slice + size;
        return slice;
    });
}

std::unique_ptr<Film> RenderSession::merged(const TeamResult& result) const {
    auto film = std::make_unique<Film>(film_.window(), film_.filter(), scene_->emissionExponent());
    film->addSums(result.sums, result.passes);
    return film;
}

SessionResult RenderSession::runTogether(Team& team, const RunOptions& options, const RunHooks& hooks) {
    if (options.limits.relativeError > 0)
        throw Error(
            "--error: several processes know the error of their own passes only; give --time or --passes");
    team.checkSame(identity().dump(), "rendering");
    Run run = begin(options, hooks);
    shareSlices(team, options.limits);
    const double start = steadySeconds() - secondsBefore_;
    const auto seconds = [start] { return steadySeconds() - start; };
    const double interval = meetingInterval(options);
    const bool keepsSlices = !options.checkpoint.file.empty();
    double nextMeeting = seconds() + interval;
    bool working = true, stopped = false;
    SessionResult result;
    while (true) {
        stopped = stopped || (hooks.interrupted && hooks.interrupted());
        const bool inTime = !(options.limits.seconds > 0) || seconds() < options.limits.seconds;
        working = working && !stopped && inTime && integrator_.advance();
        if (working) {
            integrator_.renderPass(film_, film_.passes());
            if (team.rank() == 0 && hooks.afterPass)
                hooks.afterPass({film_.passes(), seconds(), kInfinity, -1}, 0, integrator_.progressNote());
            if (seconds() < nextMeeting) continue;
        }
        std::vector<SliceState> own;
        if (keepsSlices && team.rank() > 0) own = integrator_.states(true);
        if (halves_) halves_->close(film_);
        const TeamResult all =
            team.meet({film_, halves_.get(), std::move(own), nonFinite(), rays(), working, stopped});
        nextMeeting = seconds() + interval;
        stopped = all.interrupted;
        result.reason = stopped                               ? StopReason::Interrupted
                        : options.limits.passes > 0 && inTime ? StopReason::Passes
                                                              : StopReason::Time;
        if (team.rank() == 0) report(run, all, seconds(), result);
        if (all.working) continue;
        end(seconds());
        return result;
    }
}

/// Rank 0, after a meeting.
void RenderSession::report(Run& run, const TeamResult& all, double seconds, SessionResult& result) {
    const std::unique_ptr<Film> film = merged(all);
    std::unique_ptr<HalfSums> halves;
    if (halves_) {
        halves = std::make_unique<HalfSums>(all.halves.size());
        halves->add(all.halves, all.firstPasses);
    }
    const auto slices = [&] {
        std::map<uint32_t, SliceState> states;
        for (SliceState& s : integrator_.states()) states[s.index] = std::move(s);
        for (const SliceState& s : all.slices) states[s.index] = s;
        std::vector<SliceState> list;
        for (auto& [index, state] : states) list.push_back(std::move(state));
        return list;
    };
    const Snapshot now{*film,         halves.get(), {film->passes(), seconds, film->relativeError(), -1},
                       all.nonFinite, all.rays,     slices};
    if (all.working)
        saveWhatIsDue(run, now);
    else
        conclude(run, now, result);
}

}  // namespace metrolux::core
