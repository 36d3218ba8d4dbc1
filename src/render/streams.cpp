#include "render/streams.h"

#include "base/error.h"
#include "base/rng.h"
#include "base/state_archive.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

uint64_t streamSeed(uint64_t seed, uint32_t stream, uint32_t count) {
    constexpr uint64_t kPurpose = 0x73747265616d;
    return count == 1 ? seed : hashKey(seed, kPurpose, stream);
}

uint32_t passesOfStream(uint32_t stream, uint32_t count, uint32_t passes) {
    return passes / count + (stream < passes % count ? 1 : 0);
}

uint32_t passesOfChoice(const StreamChoice& choice, uint32_t passes) {
    uint32_t sum = 0;
    for (uint32_t s = choice.first; s <= choice.last; ++s) sum += passesOfStream(s, choice.count, passes);
    if (sum == 0)
        throw Error("streams {} to {} of {}: found {} passes in all, expected enough for one of them",
                    choice.first, choice.last, choice.count, passes);
    return sum;
}

StreamedIntegrator::StreamedIntegrator(Make make, const StreamChoice& choice, uint32_t totalPasses)
    : make_(std::move(make)),
      next_([this] { return nextInOrder(); }),
      choice_(choice),
      totalPasses_(totalPasses),
      streams_(choice.last - choice.first + 1) {
    // What an integrator refuses is refused before the first pass.
    wake(choice_.first);
}

bool StreamedIntegrator::unfinished(uint32_t stream) const {
    return totalPasses_ == 0 || at(stream).passes < passesOfStream(stream, choice_.count, totalPasses_);
}

std::optional<uint32_t> StreamedIntegrator::nextInOrder() const {
    std::optional<uint32_t> next;
    for (uint32_t s = choice_.first; s <= choice_.last; ++s) {
        if (!unfinished(s)) continue;
        if (totalPasses_ > 0) return s;
        if (!next || at(s).passes < at(*next).passes) next = s;
    }
    return next;
}

void StreamedIntegrator::wake(uint32_t stream) {
    if (alive_ == stream) return;
    if (alive_ && at(*alive_).passes > 0) {
        StateWriter writer;
        integrator_->saveState(writer);
        at(*alive_).state = writer.take();
    }
    alive_.reset();
    if (integrator_) nonFiniteOfOthers_ += integrator_->nonFinite();
    integrator_.reset();  // before the next one, for the memory
    integrator_ = make_(stream);
    if (at(stream).passes > 0) {
        StateReader reader(at(stream).state);
        integrator_->loadState(reader);
        reader.checkEnd();
    }
    alive_ = stream;
    turn_ = 0;
}

bool StreamedIntegrator::advance() {
    const bool turnOver = totalPasses_ == 0 && turn_ >= kTurn && streams_.size() > 1;
    // The stream that was made first, but has no passes, is to be taken like any other.
    if (alive_ && at(*alive_).own && !turnOver && unfinished(*alive_)) return true;
    const std::optional<uint32_t> next = next_();
    if (!next) return false;
    wake(*next);
    at(*next).own = true;
    return true;
}

void StreamedIntegrator::addPass(Film& film, uint32_t) {
    if (!advance()) throw Error("no stream of this rendering has passes left");
    Stream& stream = at(*alive_);
    integrator_->addPass(film, stream.passes);
    ++stream.passes;
    ++turn_;
}

TechniqueCounts StreamedIntegrator::nonFinite() const {
    TechniqueCounts counts = Integrator::nonFinite();  // what the film has left out
    counts += nonFiniteOfOthers_;
    counts += integrator_->nonFinite();
    return counts;
}

nlohmann::json StreamedIntegrator::statistics() const {
    nlohmann::json j = integrator_->statistics();
    if (choice_.count == 1) return j;
    nlohmann::json passes = nlohmann::json::object();
    for (uint32_t s = choice_.first; s <= choice_.last; ++s)
        if (at(s).passes > 0) passes[std::to_string(s)] = at(s).passes;
    return {{"streams", choice_.count},
            {"passes_of_streams", passes},
            {"last_stream", alive_.value_or(choice_.first)},
            {"of_last_stream", j}};
}

std::string StreamedIntegrator::progressNote() const {
    const std::string note = integrator_->progressNote();
    if (choice_.count == 1) return note;
    return fmt::format("stream {}{}{}", alive_.value_or(choice_.first), note.empty() ? "" : ", ", note);
}

std::vector<StreamState> StreamedIntegrator::states(bool ownOnly) const {
    std::vector<StreamState> result;
    for (uint32_t s = choice_.first; s <= choice_.last; ++s) {
        const Stream& stream = at(s);
        if (stream.passes == 0 || (ownOnly && !stream.own)) continue;
        result.push_back({s, stream.passes, stream.state});
        if (s != alive_) continue;
        StateWriter writer;
        integrator_->saveState(writer);
        result.back().integrator = writer.take();
    }
    return result;
}

void StreamedIntegrator::restore(std::vector<StreamState> states) {
    alive_.reset();
    for (StreamState& s : states) {
        if (s.index < choice_.first || s.index > choice_.last)
            throw Error("saved state: found stream {}, expected {} to {}", s.index, choice_.first,
                        choice_.last);
        at(s.index) = {s.passes, false, std::move(s.integrator)};
    }
    wake(nextInOrder().value_or(choice_.first));
    at(*alive_).own = choice_.count == 1;
}

void StreamedIntegrator::saveState(StateWriter& writer) const { writer(states()); }
void StreamedIntegrator::loadState(StateReader& reader) {
    std::vector<StreamState> saved;
    reader(saved);
    restore(std::move(saved));
}

}  // namespace metrolux::core
