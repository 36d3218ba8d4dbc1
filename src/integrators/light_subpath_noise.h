#pragma once
#include "base/state.h"
#include "image/film.h"
#include "integrators/pixel_importance.h"

#include <vector>

namespace metrolux::core {

/// The noise that light subpaths from chains bring into a pass, found from the differences between one judged
/// pass and the next, beside that of as many independent ones, predicted from the samples of the chains. What
/// is found knows how much the steps of a chain repeat each other; their weights only assume it (the
/// inefficiency g of ReplicaMixture).
///
/// Both are variances of a pass's pixels, relative to the image, sums over the film.
class LightSubpathNoise {
  public:
    explicit LightSubpathNoise(size_t pixels) : pixels_(pixels) {}

    /// Before and after the light subpaths of an iteration of a judged pass of chains have been added to the
    /// film. `squares`: mean of PixelImportance::squares() over `samples` independent light subpaths
    /// (LightSubpathChains::squares()).
    void beginIteration(const Film& film);
    void endIteration(const Film& film, double squares, double samples);
    /// The pass has been made. It is compared with the one before if that has been judged too.
    void endPass(const PixelImportance& importance);
    /// No more passes of chains are judged for now. What has been found counts half when it goes on.
    void end();

    /// Noise of independent light subpaths over that of chains. 1 before it is known.
    double gain() const;

    /// Between two passes.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(independent_, passes_, found_, differences_);
        serializeAtMost(archive, last_, pixels_, "pixels");
        checkState(last_.empty() || last_.size() == pixels_, "noise of all pixels");
    }

  private:
    size_t pixels_;
    double independent_ = 0, passes_ = 0;
    double found_ = 0, differences_ = 0;
    std::vector<float> last_;  ///< what light subpaths have added to each pixel in the pass before, if judged
    // Of the pass under way.
    std::vector<float> before_, added_;
    double predicted_ = 0;
};

}  // namespace metrolux::core
