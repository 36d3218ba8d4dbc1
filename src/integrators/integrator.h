#pragma once
#include "base/state.h"
#include "image/film.h"
#include "scene/scene.h"

#include <metrolux/defaults.h>

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <string>

namespace metrolux::core {

/// What every integrator takes. Same options, parameters, scene and pass count: the same bits.
struct CommonOptions {
    uint64_t seed = 0;
    PathLimits limits;
    size_t memoryBytes = kDefaultMemory;  ///< bound for what an iteration stores; 0: no bound
};

/// A progressive integrator: an image after each pass (nori's integrator.h, with passes).
class Integrator {
  public:
    virtual ~Integrator() = default;
    /// Adds one pass (one sample, light path or mutation per pixel) to the film and calls film.endPass().
    virtual void renderPass(Film& film) = 0;
    /// Everything that renderPass() changes, between two passes: an integrator of the same scene and options
    /// that loads it goes on bit for bit. loadState() throws Error for what it cannot use. See Resumable.
    virtual void saveState(StateWriter& writer) const = 0;
    virtual void loadState(StateReader& reader) = 0;
    /// What a user may want to know: acceptance rates, normalizations, radius ...
    virtual nlohmann::json statistics() const = 0;
    /// Short text for the progress line, may be empty.
    virtual std::string progressNote() const { return {}; }
};

/// An empty film for the scene's camera.
Film makeFilm(const Scene& scene);

}  // namespace metrolux::core
