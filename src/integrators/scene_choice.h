#pragma once
/// The integrator of a rendering: one that is chosen, or what the scene names.

#include "integrators/registry.h"

namespace metrolux::core {

/// What is chosen where the scene's own integrator is wanted.
inline constexpr const char* kSceneIntegrator = "scene";

/// The integrator that stands for the scene's: of that name, or Mitsuba's of that type. Null if there is
/// none.
const IntegratorDescription* integratorOf(const SceneIntegrator& scene);

/// Judges the scene's <integrator>, whatever is going to render: what is left of its settings are parameters
/// of the integrator that stands for it, under their own names. Unknown ones (but in scenes of 0.x), and
/// values that they cannot have, are errors (warnings, if lenient). Those of Mitsuba that say how samples are
/// spent are warned of. Of a type that has no counterpart only the path lengths are used, which is warned of.
void settleSceneIntegrator(SceneParts& parts, bool lenient);

/// An integrator and values for its parameters.
struct IntegratorChoice {
    const IntegratorDescription* integrator;
    ParameterSet parameters;
    const std::string& name() const { return integrator->name; }
};

/// `chosen`: a name of integratorList(), or "scene". The scene's settings hold if it names this integrator,
/// and `given` over them. Throws Error, for "scene" with what is nearest to the scene's type.
IntegratorChoice chooseIntegrator(const std::string& chosen, const SceneIntegrator& scene,
                                  const ParameterValues& given = {});

}  // namespace metrolux::core
