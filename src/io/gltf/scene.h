#pragma once
#include "base/memory_budget.h"
#include "io/mitsuba/parser.h"

namespace metrolux::core::gltf {

/// Whether a file is glTF, by its name or its first bytes.
bool isGltf(const std::filesystem::path& file);

/// Reads a glTF 2.0 file (.gltf or .glb) into objects of the types that Mitsuba's scenes have. When lenient,
/// extensions that the file requires and Metrolux does not know are warnings. Throws Error.
mitsuba::ParsedScene parseGltf(const std::filesystem::path& file, bool lenient, MemoryBudget& memory);

}  // namespace metrolux::core::gltf
