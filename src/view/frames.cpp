#include "view/frames.h"

#include "base/clock.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

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

void tellOfFiles(Board& board, const Outcome& outcome, const Files& files) {
    std::vector<std::string> failures = outcome.failures;
    if (!outcome.checkpointFailure.empty()) failures.push_back(outcome.checkpointFailure);
    if (!failures.empty()) return board.tell(fmt::format("{}", fmt::join(failures, "\n")), true);
    if (outcome.passes == 0) return;
    std::vector<std::string> written;
    for (const std::filesystem::path& file : files.images) written.push_back(file.string());
    if (!files.checkpoint.empty()) written.push_back(files.checkpoint.string());
    board.tell(fmt::format("wrote {}", fmt::join(written, ", ")));
}

void beginSide(SideState& side, const std::string& integrator) {
    side.integrator = integrator;
    ++side.generation;
    side.progress = {};
    side.curve.clear();
}

}  // namespace metrolux::core::view
