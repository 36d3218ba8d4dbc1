#pragma once

namespace metrolux::core::app {

/// From now on the first SIGINT or SIGTERM only sets a flag; a second one ends the program at once. Files
/// that grow over a limit (ulimit -f) become errors, and do not end the program.
void catchInterrupts();
bool interruptRequested();

}  // namespace metrolux::core::app
