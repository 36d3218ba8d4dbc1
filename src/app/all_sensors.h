#pragma once
#include "app/render_options.h"

namespace metrolux::core::app {

/// Whether `--sensor all` was asked for.
bool wantsAllSensors(const RenderArguments& a);
/// Renders a scene by each of its sensors in turn, each to the limits; `NAME.exr` becomes `NAME.SENSOR.exr`.
/// The exit status: that of the first that was not done. Throws Error.
int renderAllSensors(const RenderArguments& a);

}  // namespace metrolux::core::app
