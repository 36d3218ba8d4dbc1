#pragma once

namespace metrolux::core::app {

/// From now on the first SIGINT, SIGTERM or SIGHUP only sets a flag; a second one ends the program at once.
/// Signals that were ignored when the program started stay ignored. Files that grow over a limit (ulimit -f)
/// and pipes that nobody reads become errors, and do not end the program.
void catchInterrupts();
bool interruptRequested();

}  // namespace metrolux::core::app
