#pragma once
#include "integrators/integrator.h"

#include <cstdint>
#include <functional>
#include <string>

namespace metrolux::core {

/// When to stop; the first limit that is reached counts. Zero: no such limit.
struct RenderLimits {
    double seconds = 0;  ///< of rendering: loading the scene is not included
    uint32_t passes = 0;
    double relativeError = 0;  ///< Film::relativeError
    bool any() const { return seconds > 0 || passes > 0 || relativeError > 0; }
};

/// Full: the film takes no more than Film::kMostPasses.
enum class StopReason { Time, Passes, Error, Interrupted, Full };
const char* stopReasonName(StopReason reason);

/// What is known after a pass.
struct PassReport {
    uint32_t passes = 0;
    double seconds = 0;
    double relativeError = 0;      ///< infinity before it is known
    double secondsRemaining = -1;  ///< estimate until a limit is reached; negative when nothing can be said
};

/// What the loop asks of its surroundings, so that a test can play them.
struct PassLoopHooks {
    std::function<double()> clock;                     ///< seconds, any origin; default: steady clock
    std::function<bool()> interrupted;                 ///< asked between passes; default: never
    std::function<void(const PassReport&)> afterPass;  ///< default: nothing
    double secondsBefore = 0;                          ///< of the passes that the film has already
};

/// Renders passes until a limit is reached or somebody interrupts, which ends the pass in progress first.
/// Unless interrupted before it, the film has a pass at least; a film that comes with passes gets more until
/// the limits are reached, which count all. Under a time limit no pass is begun that
/// would probably exceed the limit by more than stopping now would fall short of it. Throws Error when there
/// is no limit.
StopReason renderPasses(Integrator& integrator, Film& film, const RenderLimits& limits,
                        const PassLoopHooks& hooks);

}  // namespace metrolux::core
