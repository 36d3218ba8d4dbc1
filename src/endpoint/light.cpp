#include "endpoint/light.h"

#include <algorithm>
#include <cmath>

namespace metrolux::core {

void Light::setEmissionExponent(int exponent) {
    constexpr int kStep = 64;  // a float holds 2^64
    for (int rest = emissionExponent_ - exponent; rest != 0;) {
        const int step = std::clamp(rest, -kStep, kStep);
        scaleEmission(std::ldexp(1.0f, step));
        rest -= step;
    }
    emissionExponent_ = exponent;
}

}  // namespace metrolux::core
