#include "render/pass_loop.h"

#include "base/clock.h"
#include "base/error.h"

#include <optional>

namespace metrolux::core {
namespace {

std::optional<StopReason> reached(const RenderLimits& limits, const PassReport& report) {
    const double secondsPerPass = report.seconds / std::max(1u, report.passes);
    if (limits.passes > 0 && report.passes >= limits.passes) return StopReason::Passes;
    if (limits.relativeError > 0 && report.relativeError <= limits.relativeError) return StopReason::Error;
    if (limits.seconds > 0 && report.seconds + 0.5 * secondsPerPass >= limits.seconds)
        return StopReason::Time;
    return std::nullopt;
}

double estimateRemaining(const RenderLimits& limits, const PassReport& report) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    double remaining = kNever;
    if (limits.seconds > 0) remaining = std::min(remaining, limits.seconds - report.seconds);
    if (limits.passes > 0)
        remaining =
            std::min(remaining, (static_cast<double>(limits.passes) / report.passes - 1) * report.seconds);
    // The error falls with the square root of the number of passes.
    if (limits.relativeError > 0 && std::isfinite(report.relativeError))
        remaining =
            std::min(remaining, (sqr(report.relativeError / limits.relativeError) - 1) * report.seconds);
    return remaining == kNever ? -1 : std::max(0.0, remaining);
}

}  // namespace

const char* stopReasonName(StopReason reason) {
    switch (reason) {
        case StopReason::Time:
            return "time";
        case StopReason::Passes:
            return "passes";
        case StopReason::Error:
            return "error";
        case StopReason::Interrupted:
            return "interrupted";
        case StopReason::Full:
            return "full";
    }
    return "unknown";
}

StopReason renderPasses(Integrator& integrator, Film& film, const RenderLimits& limits,
                        const PassLoopHooks& hooks) {
    if (!limits.any()) throw Error("rendering needs a limit: a time, a number of passes or an error");
    const auto clock = hooks.clock ? hooks.clock : steadySeconds;
    const double start = clock();
    const auto report = [&] {
        PassReport r{film.passes(), clock() - start + hooks.secondsBefore, film.relativeError(), -1};
        r.secondsRemaining = estimateRemaining(limits, r);
        return r;
    };
    if (film.passes() > 0)
        if (const auto reason = reached(limits, report())) return *reason;
    while (true) {
        if (film.passes() >= Film::kMostPasses) return StopReason::Full;
        if (hooks.interrupted && hooks.interrupted()) return StopReason::Interrupted;
        integrator.renderPass(film, film.passes());
        const PassReport now = report();
        if (hooks.afterPass) hooks.afterPass(now);
        if (const auto reason = reached(limits, now)) return *reason;
    }
}

}  // namespace metrolux::core
