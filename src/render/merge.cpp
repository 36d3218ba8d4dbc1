#include "render/merge.h"

#include "base/error.h"
#include "base/state_archive.h"

namespace metrolux::core {

void PartMerger::add(const std::string& name, const Checkpoint& part) {
    const nlohmann::json identity = nlohmann::json::parse(part.identity);
    const ReconstructionFilter unused(ReconstructionFilter::Kind::Box, {});  // nothing is rendered
    if (!film_) {
        firstName_ = name;
        identity_ = identity;
        film_ = std::make_unique<Film>(part.window, unused);
    }
    const auto different = differences(identity, identity_);
    if (!different.empty())
        throw Error("'{}' does not belong to the rendering of '{}':\n  {}", name, firstName_,
                    fmt::join(different, "\n  "));
    addSlices(name, part);
    Film film(part.window, unused);
    try {
        StateReader reader(part.film);
        film.loadState(reader);
        reader.checkEnd();
    } catch (const Error& problem) {
        throw Error("checkpoint '{}' is damaged: {}", name, problem.what());
    }
    film_->add(film);
    nonFinite_ += part.nonFinite;
    seconds_ += part.seconds;
    rays_.intersectRays += part.rays.intersectRays;
    rays_.shadowRays += part.rays.shadowRays;
    rays_.secondsInEmbree += part.rays.secondsInEmbree;
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
