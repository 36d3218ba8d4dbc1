#pragma once
#include "base/math.h"

#include <cstdint>

namespace metrolux::core {

/// The wavelength that all paths of a pass have in a scene with dispersion, and what it looks like
/// (docs/explain/dispersion.md). Indices of refraction are those at this wavelength; what comes by a path
/// that has met one is multiplied by the color.
struct Wavelength {
    float nanometers = 0;  ///< 0: none, and every index is the one at the d line
    /// In linear Rec.709, over the density of the wavelength: its mean over u is (1, 1, 1). Components may be
    /// negative.
    Rgb color{1.0f};

    bool isGiven() const { return nanometers > 0; }
    /// `u` in [0, 1) chooses it.
    static Wavelength at(double u);
    /// Of a pass: a low-discrepancy sequence over the passes, shifted by the seed.
    static Wavelength ofPass(uint64_t seed, uint32_t pass);

    static constexpr int kFirst = 380, kLast = 750;  ///< nanometers
};

}  // namespace metrolux::core
