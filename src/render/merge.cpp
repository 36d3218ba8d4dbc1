#include "render/merge.h"

#include "base/error.h"
#include "base/state_archive.h"

namespace metrolux::core {

void PartMerger::add(const std::string& name, const Checkpoint& part) {
    nlohmann::json identity = nlohmann::json::parse(part.identity);
    const ReconstructionFilter unused(ReconstructionFilter::Kind::Box, {});  // nothing is rendered
    if (!film_) {
        firstName_ = name;
        identity_ = identity;
        exponent_ = identity.value(kEmissionExponentKey, 0);
        film_ = std::make_unique<Film>(part.window, unused, exponent_);
    }
    nlohmann::json first = identity_;
    hasOtherBuilds_ |= !buildDifferences(identity, first).empty();
    const auto different = differences(identity, first);
    if (!different.empty())
        throw Error("'{}' does not belong to the rendering of '{}':\n  {}", name, firstName_,
                    fmt::join(different, "\n  "));
    addSlices(name, part);
    Film film(part.window, unused, exponent_);
    try {
        StateReader reader(part.film);
        film.loadState(reader);
        reader.checkEnd();
        addHalves(part);
    } catch (const Error& problem) {
        throw Error("checkpoint '{}' is damaged: {}", name, problem.what());
    }
    film_->add(film);
    nonFinite_ += part.nonFinite;
    seconds_ += part.seconds;
    rays_ += part.rays;
}

/// Identities say that all parts have halves, or none.
void PartMerger::addHalves(const Checkpoint& part) {
    if (!identity_.contains(kHalvesKey)) return;
    DenoisingState state = DenoisingState::parse(part.denoising, film_->sums().size());
    if (denoising_)
        denoising_->halves.add(state.halves);
    else
        denoising_ = std::move(state);
}

void PartMerger::addSlices(const std::string& name, const Checkpoint& part) {
    for (const SliceState& slice : part.slices) {
        const auto [other, isNew] = origin_.emplace(slice.index, name);
        if (!isNew)
            throw Error("slice {} is in '{}' and in '{}': parts may not overlap", slice.index, other->second,
                        name);
        passes_[slice.index] = slice.passes;
    }
}

std::vector<uint32_t> PartMerger::missing() const {
    std::vector<uint32_t> result;
    for (uint32_t s = 0; s < identity_[kSliceCountKey].get<uint32_t>(); ++s)
        if (!passes_.contains(s)) result.push_back(s);
    return result;
}

}  // namespace metrolux::core
