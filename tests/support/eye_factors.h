#pragma once
#include "base/rng.h"
#include "transport/eye_factors.h"

namespace metrolux::core::test {

/// Factors of all sizes, which differ from region to region and class to class: two passes of estimates that
/// are as like each other in a pixel's region as chance says.
inline void setRandomEyeFactors(EyeFactors& factors, uint32_t pixels, CounterRng& rng) {
    std::vector<std::array<double, std::tuple_size_v<EyeEstimate>>> likeness(pixels / 16 + 1);
    for (auto& l : likeness)
        for (double& x : l) x = rng.nextDouble();
    for (int pass = 0; pass < 2; ++pass) {
        for (uint32_t pixel = 0; pixel < pixels; ++pixel) {
            EyeEstimate estimate;
            for (size_t k = 0; k < estimate.size(); ++k)
                estimate[k] = static_cast<float>(1 + likeness[pixel / 16][k] * (rng.nextDouble() - 0.5));
            factors.set(pixel, estimate);
        }
        factors.endPass();
    }
}

}  // namespace metrolux::core::test
