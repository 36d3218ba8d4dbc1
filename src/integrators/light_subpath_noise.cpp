#include "integrators/light_subpath_noise.h"

#include "base/parallel.h"

namespace metrolux::core {

void LightSubpathNoise::beginIteration(const Film& film) {
    before_.resize(pixels_);
    parallelFor(pixels_, [&](size_t i) { before_[i] = static_cast<float>(film.passLuminance(i)); });
}

void LightSubpathNoise::endIteration(const Film& film, double squares, double samples) {
    added_.resize(pixels_);
    parallelFor(pixels_,
                [&](size_t i) { added_[i] += static_cast<float>(film.passLuminance(i)) - before_[i]; });
    predicted_ += squares / samples;
}

void LightSubpathNoise::endPass(const PixelImportance& importance) {
    independent_ += predicted_;
    ++passes_;
    if (!last_.empty()) {
        double sum = 0;
        for (size_t i = 0; i < pixels_; ++i)
            sum += 0.5 * sqr(double(importance.of(i)) * (double(added_[i]) - double(last_[i])));
        found_ += sum;
        ++differences_;
    }
    last_ = std::move(added_);
    added_ = {};
    predicted_ = 0;
}

void LightSubpathNoise::end() {
    before_ = last_ = {};
    for (double* sum : {&independent_, &passes_, &found_, &differences_}) *sum *= 0.5;
}

double LightSubpathNoise::gain() const {
    if (!(found_ > 0)) return 1;
    return independent_ / passes_ / (found_ / differences_);
}

}  // namespace metrolux::core
