#pragma once
#include "base/parameter.h"

#include <string>
#include <vector>

namespace metrolux::core {

/// The scene's <integrator> as it was written, but for its path lengths (PathLimits). What type and settings
/// mean is for those to say who know the integrators.
struct SceneIntegrator {
    struct Setting {
        std::string name;
        ParameterValue value;
        std::string
            where;  ///< how a message begins: scene.xml:12: <integrator type="vcm">: property "radius"
    };
    std::string type = "path";
    std::string where;  ///< scene.xml:12: <integrator type="vcm">; empty: the scene has none
    std::vector<Setting> settings;
    bool legacy = false;  ///< from a 0.x scene, which may hold settings of another type
};

}  // namespace metrolux::core
