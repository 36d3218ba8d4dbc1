#pragma once
#include "image/film.h"
#include "render/checkpoint.h"
#include "render/denoiser.h"

#include <nlohmann/json.hpp>

#include <map>
#include <optional>

namespace metrolux::core {

/// Joins the checkpoints of slices that were rendered apart. Sums are exact, so that the image is that of
/// one process which rendered all of them.
class PartMerger {
  public:
    /// Throws Error for a part of another rendering than the first one, and for a slice that is there
    /// already. `name` is for messages.
    void add(const std::string& name, const Checkpoint& part);

    /// After the first add(): mean over all passes, so that each part weighs as many as it has.
    const Film& film() const { return *film_; }
    /// Null where the parts have none, as they were rendered without denoising.
    const DenoisingState* denoising() const { return denoising_ ? &*denoising_ : nullptr; }
    const nlohmann::json& identity() const { return identity_; }
    double seconds() const { return seconds_; }  ///< of all parts
    const RayStatistics& rays() const { return rays_; }
    const TechniqueCounts& nonFinite() const { return nonFinite_; }
    /// Whether parts come from different builds, which could differ in last bits.
    bool hasOtherBuilds() const { return hasOtherBuilds_; }
    /// Passes of each slice.
    const std::map<uint32_t, uint32_t>& passes() const { return passes_; }
    /// Slices that no part has.
    std::vector<uint32_t> missing() const;

  private:
    void addHalves(const Checkpoint& part);
    void addSlices(const std::string& name, const Checkpoint& part);
    std::string firstName_;
    nlohmann::json identity_;
    std::unique_ptr<Film> film_;
    std::optional<DenoisingState> denoising_;
    int exponent_ = 0;
    bool hasOtherBuilds_ = false;
    double seconds_ = 0;
    RayStatistics rays_;
    TechniqueCounts nonFinite_{};
    std::map<uint32_t, uint32_t> passes_;
    std::map<uint32_t, std::string> origin_;
};

}  // namespace metrolux::core
