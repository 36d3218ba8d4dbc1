#pragma once
/// Renders a scene from the first pass to the files on disk.

#include "render/aov.h"
#include "render/output.h"
#include "render/pass_loop.h"
#include "render/progress.h"

#include <nlohmann/json.hpp>

namespace metrolux {

struct SessionOptions {
    std::string integrator = "mcmc_vcm";  ///< a name of integratorList(), or "scene" for what the scene names
    IntegratorOptions integratorOptions;
    RenderLimits limits;
    std::vector<std::filesystem::path> outputs;
    OutputSet::Display display;
    std::vector<Aov> aovs;
    double saveEvery = 60;  ///< seconds between intermediate images; 0: none
    std::string version;    ///< for statistics and metadata
};

struct SessionResult {
    StopReason reason = StopReason::Interrupted;
    uint32_t passes = 0;              ///< 0: interrupted before there was an image, nothing was written
    OutputSet::RescueResult written;  ///< of the final image
    nlohmann::json statistics;
};

/// The integrator that stands for a Mitsuba integrator type ("direct" -> "path", "ptracer" -> "light" ...).
/// Names of this program's integrators stand for themselves. Throws Error for what it does not know.
std::string integratorForScene(const std::string& sceneType);

class RenderSession {
  public:
    /// Throws Error when the integrator is unknown or an output could not be written: before any work is
    /// done.
    RenderSession(const Scene& scene, SessionOptions options);
    /// With an integrator made elsewhere; options.integrator is its name in the statistics.
    RenderSession(const Scene& scene, SessionOptions options, std::unique_ptr<Integrator> integrator);

    /// Renders until a limit is reached or `interrupted` says so (asked between passes), and writes the
    /// files.
    SessionResult run(ProgressReporter& progress, const std::function<bool()>& interrupted);

  private:
    RenderedFrame frame(const PassReport& report) const;
    nlohmann::json statistics(const PassReport& report, StopReason reason) const;
    void saveIntermediate(const PassReport& report, ProgressReporter& progress);

    const Scene& scene_;
    SessionOptions options_;
    OutputSet outputs_;
    Film film_;
    std::unique_ptr<Integrator> integrator_;
    std::vector<ImageLayer> cameraLayers_;
    double nextSave_ = 0, secondsForAovs_ = 0;
};

}  // namespace metrolux
