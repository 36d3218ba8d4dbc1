#pragma once
/// The integrators by name.

#include "integrators/description.h"

#include <nlohmann/json_fwd.hpp>

namespace metrolux::core {

/// All of them, as one would present them.
const std::vector<IntegratorDescription>& integratorList();
/// Throws Error for an unknown name, with the nearest known one.
const IntegratorDescription& findIntegrator(const std::string& name);
/// The names of those that have the parameter.
std::vector<std::string> integratorsWith(const std::string& parameter);

/// All parameters of the integrator with these values. Throws Error for unknown names and values.
ParameterSet parameterSet(const IntegratorDescription& integrator, const ParameterValues& values);
/// Name and value of each.
nlohmann::json toJson(const ParameterSet& parameters);

/// Throws Error for an unknown name, parameter or value.
std::unique_ptr<Integrator> makeIntegrator(const std::string& name, const Scene& scene,
                                           const CommonOptions& options = {},
                                           const ParameterValues& values = {});

}  // namespace metrolux::core
