#include "image/exact_sum.h"

#include "base/rng.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

__extension__ using Integer = __int128;

/// By the definition: the term in units of 2^-bits, to the nearest integer, ties to even.
template <int bits>
double rounded(double term) {
    return std::ldexp(static_cast<double>(static_cast<Integer>(std::nearbyint(std::ldexp(term, bits)))),
                      -bits);
}

template <int bits>
void expectExact(double term) {
    ExactSum<bits> sum;
    sum.add(term);
    EXPECT_EQ(sum.value(), rounded<bits>(term)) << bits << " bits, " << term;
    // A sum of many tells the last bit: 3 t + t - 4 t = 0.
    sum.add(term);
    sum.add(term);
    sum.add(term);
    for (int i = 0; i < 4; ++i) sum.add(-term);
    EXPECT_EQ(sum.value(), 0.0) << bits << " bits, " << term;
}

TEST(ExactSum, TermsAreRoundedToTheNearestUnit) {
    CounterRng rng(3);
    for (int exponent = -80; exponent <= 36; ++exponent)
        for (int i = 0; i < 50; ++i) {
            const double term = std::ldexp(2 * rng.nextDouble() - 1, exponent);
            expectExact<63>(term);
            expectExact<26>(term);
            if (exponent <= 0) expectExact<100>(term);
        }
    // Halves of a unit, around the place where the two machine words meet.
    for (const double units :
         {0.5, 1.5, 2.5, 0x1p39 + 0.5, 0x1p40 - 0.5, 0x1p40 + 0.5, 0x1p40 + 1.5, 0x1p52 - 0.5})
        for (const double sign : {-1.0, 1.0}) expectExact<26>(std::ldexp(sign * units, -26));
    expectExact<63>(PixelSum::kLargest);
    expectExact<63>(-PixelSum::kLargest);
}

}  // namespace
}  // namespace metrolux::core
