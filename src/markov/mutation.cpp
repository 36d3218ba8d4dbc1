#include "markov/mutation.h"

#include <cmath>
#include <numbers>

namespace metrolux::core {

float MutationKernel::mutated(float x, CounterRng& rng) const {
    // Both branches of eq. 4, and of [Kel02]'s, are a function of a uniform number, with a sign.
    const float xi = rng.next1D();
    const float uniform = xi < 0.5f ? 2.0f * xi : 2.0f * xi - 1.0f;
    float magnitude;
    if (kind_ == Kind::Adaptive) {
        magnitude = std::pow(uniform, static_cast<float>(1.0 / theta_));
    } else {
        constexpr float kLargest = 1.0f / 64, kLogRatio = 4 * std::numbers::ln2_v<float>;  // to 1/1024
        magnitude = kLargest * std::exp(-kLogRatio * uniform);
    }
    return wrapUnit(xi < 0.5f ? x + magnitude : x - magnitude);
}

void MutationKernel::mutate(const PrimarySample& from, PrimarySample& to, CounterRng& rng) const {
    to.resize(from.size());
    for (size_t i = 0; i < from.size(); ++i) to[i] = mutated(from[i], rng);
}

void MutationKernel::shareTheta(const std::vector<MutationKernel*>& kernels) {
    double sum = 0;
    for (const MutationKernel* k : kernels) sum += k->theta_;
    for (MutationKernel* k : kernels) k->theta_ = sum / double(kernels.size());
}

void MutationKernel::adapt(bool accepted) {
    const bool adapts = !settled();
    ++tried_;
    accepted_ += accepted;
    if (!adapts) return;
    theta_ += (acceptance() - kGoalAcceptance) / static_cast<double>(tried_);
    theta_ = std::clamp(theta_, kMinimalTheta, kMaximalTheta);
}

}  // namespace metrolux::core
