#pragma once
/// Brings what a session has to the board, on the thread that renders.

#include "view/board.h"

namespace metrolux::core::view {

/// The picture so far.
void publish(Board& board, int side, Session& session, int scale = 1);
/// After a pass: a frame if it is time for one.
void afterPass(Board& board, int side, Session& session, const Progress& progress);
/// Tells viewers what became of the files that were to be written; nothing before the first pass.
void tellOfFiles(Board& board, const Outcome& outcome, const Files& files);
/// The next picture is of something else: `curve`, frame and layers of before are forgotten, the frame once
/// there is another.
void beginSide(SideState& side, const std::string& integrator);

}  // namespace metrolux::core::view
