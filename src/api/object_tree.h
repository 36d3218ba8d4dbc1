#pragma once
#include "io/mitsuba/parser.h"

#include <metrolux/object.h>

namespace metrolux::core::api {

/// The elements that a scene file with these objects would have: the loader takes both alike. `folder` is
/// where files are looked for. Throws Error that names the object by its path ("scene:lamp.emitter").
mitsuba::ParsedScene parsedScene(const Object& scene, const std::filesystem::path& folder);
/// The same of a sensor that stands alone.
std::shared_ptr<mitsuba::Element> parsedSensor(const Object& sensor);

/// Size and checksum of all that an element says, nested ones included.
std::string fingerprintOf(const mitsuba::Element& element);

}  // namespace metrolux::core::api
