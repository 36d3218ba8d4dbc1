#pragma once

namespace metrolux::core {

/// The function `symbol` of a library of ours ("metrolux_mpi.so"), which is loaded now and stays: from where
/// this code is, or from where it is installed. Null if there is no such file; throws Error if it cannot be
/// loaded. `isGlobal`: what it links against serves libraries that are loaded later.
void* loadFunction(const char* library, const char* symbol, bool isGlobal);

}  // namespace metrolux::core
