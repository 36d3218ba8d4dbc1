#include "render/slices.h"

#include "base/error.h"
#include "base/rng.h"
#include "base/state_archive.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

uint64_t sliceSeed(uint64_t seed, uint32_t slice, uint32_t count) {
    constexpr uint64_t kPurpose = 0x73747265616d;
    return count == 1 ? seed : hashKey(seed, kPurpose, slice);
}

uint32_t passesOfSlice(uint32_t slice, uint32_t count, uint32_t passes) {
    return passes / count + (slice < passes % count ? 1 : 0);
}

uint32_t passesOfChoice(const SliceChoice& choice, uint32_t passes) {
    uint32_t sum = 0;
    for (uint32_t s = choice.first; s <= choice.last; ++s) sum += passesOfSlice(s, choice.count, passes);
    if (sum == 0)
        throw Error("slices {} to {} of {}: found {} passes in all, expected enough for one of them",
                    choice.first, choice.last, choice.count, passes);
    return sum;
}

SlicedIntegrator::SlicedIntegrator(Make make, const SliceChoice& choice, uint32_t totalPasses)
    : make_(std::move(make)),
      next_([this] { return nextInOrder(); }),
      choice_(choice),
      totalPasses_(totalPasses),
      slices_(choice.last - choice.first + 1) {
    // What an integrator refuses is refused before the first pass.
    wake(choice_.first);
}

bool SlicedIntegrator::unfinished(uint32_t slice) const {
    return totalPasses_ == 0 || at(slice).passes < passesOfSlice(slice, choice_.count, totalPasses_);
}

std::optional<uint32_t> SlicedIntegrator::nextInOrder() const {
    std::optional<uint32_t> next;
    for (uint32_t s = choice_.first; s <= choice_.last; ++s) {
        if (!unfinished(s)) continue;
        if (totalPasses_ > 0) return s;
        if (!next || at(s).passes < at(*next).passes) next = s;
    }
    return next;
}

void SlicedIntegrator::wake(uint32_t slice) {
    if (alive_ == slice) return;
    if (alive_ && at(*alive_).passes > 0) {
        StateWriter writer;
        integrator_->saveState(writer);
        at(*alive_).state = writer.take();
    }
    alive_.reset();
    if (integrator_) nonFiniteOfOthers_ += integrator_->nonFinite();
    integrator_.reset();  // before the next one, for the memory
    integrator_ = make_(slice);
    if (at(slice).passes > 0) {
        StateReader reader(at(slice).state);
        integrator_->loadState(reader);
        reader.checkEnd();
    }
    alive_ = slice;
    turn_ = 0;
}

bool SlicedIntegrator::advance() {
    const bool turnOver = totalPasses_ == 0 && turn_ >= kTurn && slices_.size() > 1;
    // The slice that was made first, but has no passes, is to be taken like any other.
    if (alive_ && at(*alive_).own && !turnOver && unfinished(*alive_)) return true;
    const std::optional<uint32_t> next = next_();
    if (!next) return false;
    wake(*next);
    at(*next).own = true;
    return true;
}

void SlicedIntegrator::addPass(Film& film, uint32_t) {
    if (!advance()) throw Error("no slice of this rendering has passes left");
    Slice& slice = at(*alive_);
    // Odd slices begin with the second half, so that slices of one pass make both.
    if (halves_) halves_->enter(isOfFirstHalf(slice.passes) == (*alive_ % 2 == 0), film);
    integrator_->addPass(film, slice.passes);
    ++slice.passes;
    ++turn_;
}

TechniqueCounts SlicedIntegrator::nonFinite() const {
    TechniqueCounts counts = Integrator::nonFinite();  // what the film has left out
    counts += nonFiniteOfOthers_;
    counts += integrator_->nonFinite();
    return counts;
}

nlohmann::json SlicedIntegrator::statistics() const {
    nlohmann::json j = integrator_->statistics();
    if (choice_.count == 1) return j;
    nlohmann::json passes = nlohmann::json::object();
    for (uint32_t s = choice_.first; s <= choice_.last; ++s)
        if (at(s).passes > 0) passes[std::to_string(s)] = at(s).passes;
    return {{"slices", choice_.count},
            {"passes_of_slices", passes},
            {"last_slice", alive_.value_or(choice_.first)},
            {"of_last_slice", j}};
}

std::string SlicedIntegrator::progressNote() const {
    const std::string note = integrator_->progressNote();
    if (choice_.count == 1) return note;
    return fmt::format("slice {}{}{}", alive_.value_or(choice_.first), note.empty() ? "" : ", ", note);
}

std::vector<SliceState> SlicedIntegrator::states(bool ownOnly) const {
    std::vector<SliceState> result;
    for (uint32_t s = choice_.first; s <= choice_.last; ++s) {
        const Slice& slice = at(s);
        if (slice.passes == 0 || (ownOnly && !slice.own)) continue;
        result.push_back({s, slice.passes, slice.state});
        if (s != alive_) continue;
        StateWriter writer;
        integrator_->saveState(writer);
        result.back().integrator = writer.take();
    }
    return result;
}

void SlicedIntegrator::restore(std::vector<SliceState> states) {
    alive_.reset();
    for (SliceState& s : states) {
        if (s.index < choice_.first || s.index > choice_.last)
            throw Error("saved state: found slice {}, expected {} to {}", s.index, choice_.first,
                        choice_.last);
        at(s.index) = {s.passes, false, std::move(s.integrator)};
    }
    wake(nextInOrder().value_or(choice_.first));
    at(*alive_).own = choice_.count == 1;
}

void SlicedIntegrator::saveState(StateWriter& writer) const { writer(states()); }
void SlicedIntegrator::loadState(StateReader& reader) {
    std::vector<SliceState> saved;
    reader(saved);
    restore(std::move(saved));
}

}  // namespace metrolux::core
