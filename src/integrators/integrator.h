#pragma once
#include "base/state.h"
#include "image/film.h"
#include "scattering/wavelength.h"
#include "scene/scene.h"
#include "transport/technique.h"

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
    /// Adds pass number `pass` (from 0) to the film and closes it there.
    void renderPass(Film& film, uint32_t pass);
    /// Adds one sample, light subpath or mutation for each pixel; `pass` names the random numbers.
    virtual void addPass(Film& film, uint32_t pass) = 0;
    /// Contributions that were left out since the integrator was made (docs/explain/reliability.md).
    virtual TechniqueCounts nonFinite() const { return nonFinite_.counts(); }
    /// Everything that addPass() changes and later passes depend on, between two passes: an integrator of
    /// the same scene and options that loads it goes on bit for bit. loadState() throws Error for what it
    /// cannot use. See Resumable.
    virtual void saveState(StateWriter& writer) const = 0;
    virtual void loadState(StateReader& reader) = 0;
    /// What a user may want to know: acceptance rates, normalizations, radius ...
    virtual nlohmann::json statistics() const = 0;
    /// Short text for the progress line, may be empty.
    virtual std::string progressNote() const { return {}; }

  protected:
    NonFiniteCounts nonFinite_;  ///< for the passes
};

/// What all paths of a pass have in common; not given in a scene without dispersion.
Wavelength wavelengthOf(const Scene& scene, uint64_t seed, uint32_t pass);

/// An empty film for the scene's camera.
Film makeFilm(const Scene& scene);

}  // namespace metrolux::core
