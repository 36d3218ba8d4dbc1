#pragma once

namespace metrolux::app {

/// Files that grow over a limit (ulimit -f) are errors from now on, and do not end the program.
/// From now on the first SIGINT or SIGTERM only sets a flag; a second one ends the program at once.
void catchInterrupts();
bool interruptRequested();

}  // namespace metrolux::app
