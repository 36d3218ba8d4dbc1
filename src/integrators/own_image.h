#pragma once
#include "base/parallel.h"
#include "base/state.h"
#include "image/film.h"

#include <span>
#include <vector>

namespace metrolux::core {

/// Luminances of what one integrator has added to a film. The film's own sums have the passes of other slices
/// too, and which ones depends on who renders them: nothing that an integrator decides may.
class OwnImage {
  public:
    explicit OwnImage(const FilmWindow& window)
        : window_(window), sums_(size_t(window.pixelCount())), last_(sums_.size()) {}

    /// The pass that is on the film is whole, and not closed yet.
    void addPass(const Film& film) {
        parallelFor(sums_.size(), [&](size_t i) {
            last_[i] = film.passLuminance(i);
            sums_[i] += last_[i];
        });
        ++passes_;
    }
    const FilmWindow& window() const { return window_; }
    std::span<const double> sums() const { return sums_; }
    std::span<const double> last() const { return last_; }  ///< the pass that was added last
    uint32_t passes() const { return passes_; }

    /// Between two passes.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(passes_);
        serializeElements(archive, sums_, "pixels");
    }

  private:
    FilmWindow window_;
    uint32_t passes_ = 0;
    std::vector<double> sums_, last_;
};

}  // namespace metrolux::core
