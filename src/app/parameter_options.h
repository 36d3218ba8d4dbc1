#pragma once
/// The integrators' parameters as options of a command.

#include "integrators/registry.h"

#include <CLI/CLI.hpp>

namespace metrolux::core::app {

/// An option for each parameter that an integrator has; what is given for it is in `given`, under the
/// parameter's name.
void addParameterOptions(CLI::App& app, ParameterValues& given);
/// "--chain-inefficiency" of "chain_inefficiency"; "--no-correlation-aware" of a flag that is on by default.
std::string optionOf(const ParameterInfo& parameter);
/// The parameters of all integrators, each once.
std::vector<const ParameterInfo*> allParameters();
/// Keeps those of the values that are for the integrator's parameters, and warns of the others. Throws Error
/// that names the option for a value that the integrator cannot take.
void settleParameters(ParameterValues& given, const IntegratorDescription& integrator);

}  // namespace metrolux::core::app
