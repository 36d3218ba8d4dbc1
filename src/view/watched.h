#pragma once
/// A rendering as its command line says it, with viewers who may pause, save and stop it.

#include "view/board.h"

namespace metrolux::core::view {

/// As Session::render(): the same passes and files, and those of a pause or of saving on the way. A stop by a
/// viewer is an interruption.
Outcome renderWatched(Session& session, const Limits& limits, const Hooks& hooks, const Files& files,
                      Board& board);

}  // namespace metrolux::core::view
