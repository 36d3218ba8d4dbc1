#pragma once

namespace metrolux::app {

/// From now on the first SIGINT or SIGTERM only sets a flag; a second one ends the program at once.
void catchInterrupts();
bool interruptRequested();

}  // namespace metrolux::app
