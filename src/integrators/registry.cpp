#include "integrators/registry.h"

#include "base/suggest.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace metrolux::core {

/// One line for each integrator: the function of its file that describes it.
#define METROLUX_INTEGRATORS(X) \
    X(mcmcVcmIntegrator)        \
    X(vcmIntegrator)            \
    X(bdptIntegrator)           \
    X(pathIntegrator)           \
    X(sppmIntegrator)           \
    X(vptIntegrator)            \
    X(splitMcmcIntegrator)      \
    X(lightIntegrator)          \
    X(pssmltIntegrator)         \
    X(mmltIntegrator)           \
    X(pssmltMergeIntegrator)

#define METROLUX_DECLARE(function) IntegratorDescription function();
METROLUX_INTEGRATORS(METROLUX_DECLARE)
#undef METROLUX_DECLARE

const std::vector<IntegratorDescription>& integratorList() {
#define METROLUX_CALL(function) function(),
    static const std::vector<IntegratorDescription> list{METROLUX_INTEGRATORS(METROLUX_CALL)};
#undef METROLUX_CALL
    return list;
}

const IntegratorDescription& findIntegrator(const std::string& name) {
    std::vector<std::string> names;
    for (const IntegratorDescription& integrator : integratorList()) {
        if (integrator.name == name) return integrator;
        names.push_back(integrator.name);
    }
    const std::string nearest = nearestName(name, names);
    throw Error("unknown integrator '{}'{}; known: {}", name,
                nearest.empty() ? "" : fmt::format(", did you mean '{}'?", nearest), fmt::join(names, ", "));
}

std::vector<std::string> integratorsWith(const std::string& parameter) {
    std::vector<std::string> names;
    for (const IntegratorDescription& integrator : integratorList())
        if (ParameterSet(integrator.parameters).find(parameter)) names.push_back(integrator.name);
    return names;
}

ParameterSet parameterSet(const IntegratorDescription& integrator, const ParameterValues& values) {
    ParameterSet set(integrator.parameters);
    for (const auto& [name, value] : values) {
        try {
            set.set(name, value);
        } catch (const Error& problem) {
            throw Error("integrator {}: {}", integrator.name, problem.what());
        }
    }
    return set;
}

nlohmann::json toJson(const ParameterSet& parameters) {
    nlohmann::json j = nlohmann::json::object();
    for (const ParameterInfo& info : parameters.list())
        std::visit([&](const auto& value) { j[info.name] = value; }, parameters.get(info.name));
    return j;
}

std::unique_ptr<Integrator> makeIntegrator(const std::string& name, const Scene& scene,
                                           const CommonOptions& options, const ParameterValues& values) {
    const IntegratorDescription& integrator = findIntegrator(name);
    return integrator.prepare(scene, options, parameterSet(integrator, values))(options.seed);
}

}  // namespace metrolux::core
