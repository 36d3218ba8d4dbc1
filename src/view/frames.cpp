#include "view/frames.h"

#include "base/clock.h"

namespace metrolux::core::view {

void publish(Board& board, int side, Session& session, int scale) {
    const double start = steadySeconds();
    Frame frame;
    frame.scale = scale;
    frame.window = session.scene().window();
    frame.progress = session.progress();
    const ImageView image = session.image();
    frame.color.assign(image.data, image.data + image.size());
    if (board.wantsVariance()) {
        const ImageView variance = session.variance();
        frame.variance.assign(variance.data, variance.data + variance.size());
    }
    board.publish(side, std::move(frame), steadySeconds() - start);
}

void afterPass(Board& board, int side, Session& session, const Progress& progress) {
    board.pass(side, progress);
    if (board.isDue(side)) publish(board, side, session);
}

void beginSide(SideState& side, const std::string& integrator) {
    side.integrator = integrator;
    ++side.generation;
    side.progress = {};
    side.curve.clear();
}

}  // namespace metrolux::core::view
