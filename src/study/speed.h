#pragma once
/// What a renderer's time goes to: `metrolux bench`, docs/reference/bench.md.

#include "integrators/scene_choice.h"

#include <nlohmann/json.hpp>

#include <string>

namespace metrolux::core::study {

struct SpeedOptions {
    IntegratorChoice choice;
    CommonOptions options;
    int threads = 2;
    uint32_t passes = 5;  ///< rounds that are measured; each measures a pass in every way once
    uint32_t warmUp = 3;  ///< passes before them: the chains of mcmc_vcm start with the third
};

/// Whole passes of the integrator, with `threads` threads and with one, each beside replays of the pass's
/// rays (RayReplay). The ways take turns pass by pass and all numbers are medians over the rounds, so that a
/// disturbance of the machine hits them alike. `ray_efficiency` is the time of the same calls / render time,
/// `sorted_ray_efficiency` that of the rays in sorted packets.
nlohmann::json measurePasses(const Scene& scene, const SpeedOptions& options);

/// Nanoseconds of a thread per path vertex, next-event estimation, merge, connection and splat: from passes
/// of eye and of light subpaths with and without each of them.
nlohmann::json measureTechniques(const Scene& scene, const SpeedOptions& options);

/// Both as a table for people.
std::string speedTable(const nlohmann::json& passes, const nlohmann::json& techniques);

}  // namespace metrolux::core::study
