#pragma once
/// What an integrator says of itself, in its own file: describe() makes it from the struct of its parameters.

#include "integrators/integrator.h"
#include "integrators/parameter_groups.h"

#include <functional>

namespace metrolux::core {

/// Makes integrators of a scene that differ in nothing but their seed.
using IntegratorFactory = std::function<std::unique_ptr<Integrator>(uint64_t seed)>;

struct IntegratorDescription {
    std::string name;
    std::string summary;                    ///< one line
    std::vector<std::string> mitsubaTypes;  ///< Mitsuba's integrators that it stands for, besides its name
    std::vector<ParameterInfo> parameters;
    /// The scene outlives what the factory makes. Throws Error.
    std::function<IntegratorFactory(const Scene&, const CommonOptions&, const ParameterSet&)> prepare;
};

/// Gives values that depend on the scene to those groups of parameters that leave them open.
struct ResolveParameters {
    const Scene& scene;
    const PathLimits& limits;
    template <class T, class Values>
    void operator()(const ParameterName&, T&, const Values&, const char*) const {}
    template <class Group>
    void operator()(Group& group) const {
        if constexpr (requires { group.resolve(scene, limits); }) group.resolve(scene, limits);
        group.visit(*this);
    }
};

/// The class is made from a scene, the common options, and parameters that no longer depend on the scene.
template <class Parameters, class Made>
IntegratorDescription describe(const char* name, const char* summary,
                               std::vector<std::string> mitsubaTypes = {}) {
    const auto prepare = [](const Scene& scene, const CommonOptions& options, const ParameterSet& values) {
        Parameters parameters = values.as<Parameters>();
        parameters.visit(ResolveParameters{scene, options.limits});
        return [&scene, options, parameters](uint64_t seed) {
            CommonOptions own = options;
            own.seed = seed;
            return std::make_unique<Made>(scene, own, parameters);
        };
    };
    return {name, summary, std::move(mitsubaTypes), parametersOf<Parameters>(), prepare};
}

/// Of an integrator without parameters.
struct NoParameters {
    template <class V>
    void visit(V&&) {}
};

}  // namespace metrolux::core
