#pragma once
#include "geometry/intersector.h"

#include <nlohmann/json_fwd.hpp>

namespace metrolux::core {

/// The compiler with its version, and what it was told.
extern const char* const kCompiler;
extern const char* const kBuildFlags;

/// What the last bits of an image depend on besides scene and options: the compiler and its flags, the
/// instructions that it may use, the libraries that compute, and the packets in which the machine traces
/// rays. Of the version of Metrolux that was built so.
nlohmann::json buildIdentity(const Intersector& intersector);

}  // namespace metrolux::core
