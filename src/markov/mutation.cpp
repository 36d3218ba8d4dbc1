#include "markov/mutation.h"

#include <cmath>

namespace metrolux {

void MutationKernel::mutate(const PrimarySample& from, PrimarySample& to, CounterRng& rng) const {
    to.resize(from.size());
    if (kind_ == Kind::Adaptive) {
        const float exponent = static_cast<float>(1.0 / theta_);
        for (size_t i = 0; i < from.size(); ++i) {
            // Both branches of eq. 4 are a power of a uniform number with a sign.
            const float xi = rng.next1D();
            const float magnitude = std::pow(xi < 0.5f ? 2.0f * xi : 2.0f * xi - 1.0f, exponent);
            to[i] = wrapUnit(xi < 0.5f ? from[i] + magnitude : from[i] - magnitude);
        }
        return;
    }
    constexpr float kSmallest = 1.0f / 1024, kLargest = 1.0f / 64;
    const float logRatio = std::log(kLargest / kSmallest);
    for (size_t i = 0; i < from.size(); ++i) {
        const float xi = rng.next1D();
        const float magnitude = kLargest * std::exp(-logRatio * (xi < 0.5f ? 2.0f * xi : 2.0f * xi - 1.0f));
        to[i] = wrapUnit(xi < 0.5f ? from[i] + magnitude : from[i] - magnitude);
    }
}

void MutationKernel::shareTheta(const std::vector<MutationKernel*>& kernels) {
    double sum = 0;
    for (const MutationKernel* k : kernels) sum += k->theta_;
    for (MutationKernel* k : kernels) k->theta_ = sum / double(kernels.size());
}

void MutationKernel::adapt(bool accepted) {
    ++tried_;
    accepted_ += accepted;
    if (kind_ != Kind::Adaptive) return;
    theta_ += (acceptance() - kGoalAcceptance) / static_cast<double>(tried_);
    theta_ = std::clamp(theta_, kMinimalTheta, kMaximalTheta);
}

}  // namespace metrolux
