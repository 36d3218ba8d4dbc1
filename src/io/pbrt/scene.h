#pragma once
#include "io/mitsuba/parser.h"

namespace metrolux::core::pbrt {

/// Whether a file is one of pbrt's, by its name.
bool isPbrt(const std::filesystem::path& file);

/// A pbrt-v4 scene as the objects that a Mitsuba scene of the same content has (docs/reference/pbrt.md).
/// Throws Error; leniently what is not supported is a warning.
mitsuba::ParsedScene parsePbrt(const std::filesystem::path& file, bool lenient, MemoryBudget& memory);

}  // namespace metrolux::core::pbrt
