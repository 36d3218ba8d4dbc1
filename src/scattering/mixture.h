#pragma once
#include "scattering/bsdf.h"

#include <vector>

namespace metrolux::core {

/// The sum of weight * bsdf; what the weights leave of 1 is absorbed.
struct MixtureParameters {
    struct Part {
        float weight;
        BsdfPtr bsdf;
    };
    std::vector<Part> parts;
};
/// Throws Error for negative weights, and unless their sum is above 0 and at most 1 (but for rounding).
BsdfPtr makeMixture(const MixtureParameters& parameters);

}  // namespace metrolux::core
