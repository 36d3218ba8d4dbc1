#pragma once
/// Scene files rendered inside a test: an integrator, a number of passes, a seed.

#include "base/parallel.h"
#include "integrators/registry.h"
#include "io/scene_loader.h"

#include <ctime>
#include <filesystem>
#include <memory>

namespace metrolux::core::test {

/// A scene file, loaded once and rendered many times.
class RenderableScene {
  public:
    explicit RenderableScene(const std::filesystem::path& file, const LoadOptions& options = {})
        : RenderableScene(loadScene(file, options)) {}

    /// Mean of `passes` passes, 3 floats a pixel. `radiusFactor`: merging radius as a multiple of the
    /// default, for those that merge.
    std::vector<float> render(const std::string& integrator, int passes, uint64_t seed,
                              double radiusFactor = 1, ParameterValues parameters = {}) const {
        CommonOptions options;
        options.seed = seed;
        options.limits = limits_;
        const ParameterSet known(findIntegrator(integrator).parameters);
        if (radiusFactor != 1 && known.find("radius"))
            parameters["radius"] = radiusFactor * projectedPixelRadius(*scene_, limits_);
        Film film(scene_->camera().window(), filter_);
        const auto integrates = makeIntegrator(integrator, *scene_, options, parameters);
        for (int i = 0; i < passes; ++i) integrates->renderPass(film, film.passes());
        return film.image();
    }

    const Scene& scene() const { return *scene_; }
    int width() const { return scene_->camera().window().width; }
    int height() const { return scene_->camera().window().height; }
    int pixelCount() const { return width() * height(); }
    /// The same for seeds first, first + 1 ..., which share the processors.
    std::vector<std::vector<float>> renderSeeds(const std::string& integrator, int passes, uint64_t first,
                                                int count, double radiusFactor,
                                                const ParameterValues& parameters = {}) const {
        std::vector<std::vector<float>> images(count);
        parallelFor(count, [&](size_t i) {
            images[i] = render(integrator, passes, first + i, radiusFactor, parameters);
        });
        return images;
    }
    /// Number of edges of the longest path; -1: no limit.
    int maxDepth() const { return limits_.maxDepth; }

  private:
    explicit RenderableScene(SceneParts parts)
        : limits_(parts.limits),
          filter_(parts.filterKind, parts.filter),
          scene_(std::make_unique<Scene>(std::move(parts))) {}

    PathLimits limits_;
    ReconstructionFilter filter_;
    std::unique_ptr<Scene> scene_;
};

/// Processor seconds since construction, of all threads: what a busy machine does not stretch much.
class CpuTimer {
  public:
    double seconds() const { return double(std::clock() - start_) / CLOCKS_PER_SEC; }

  private:
    std::clock_t start_ = std::clock();
};

}  // namespace metrolux::core::test
