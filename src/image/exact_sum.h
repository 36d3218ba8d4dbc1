#pragma once
/// Sums of passes that do not depend on the order of their terms, nor on how the terms are divided: films of
/// different processes add up to the same bits as one film of all passes.

#include <cmath>
#include <cstdint>

namespace metrolux::core {

/// A sum in units of 2^-fractionBits, 128 bits.
template <int fractionBits>
class ExactSum {
  public:
    /// A term; the sum of all must stay below 2^(127 - fractionBits).
    void add(double term) {
        const double units = term * kUnitsPerOne;  // exact
        // Two parts that a machine word holds: compilers call a function to convert to 128 bits.
        constexpr double kUpperUnit = 0x1p40;
        const double upper = std::trunc(units * (1 / kUpperUnit));
        if (!(std::abs(upper) < 0x1p62)) return addUnits(static_cast<Integer>(std::nearbyint(units)));
        const double lower = units - upper * kUpperUnit;  // exact
        addUnits(static_cast<Integer>(static_cast<int64_t>(upper)) * static_cast<Integer>(kUpperUnit) +
                 static_cast<int64_t>(std::nearbyint(lower)));
    }
    ExactSum& operator+=(const ExactSum& other) {
        addUnits(other.units_);
        return *this;
    }
    double value() const { return std::ldexp(static_cast<double>(units_), -fractionBits); }

    template <class Archive>
    void serialize(Archive& archive) {
        auto low = static_cast<uint64_t>(units_), high = static_cast<uint64_t>(units_ >> 64);
        archive(low, high);
        units_ = static_cast<Integer>(static_cast<Unsigned>(high) << 64 | low);
    }

  private:
    static constexpr double powerOfTwo(int exponent) { return exponent ? 2 * powerOfTwo(exponent - 1) : 1; }
    static constexpr double kUnitsPerOne = powerOfTwo(fractionBits);
    __extension__ using Integer = __int128;
    __extension__ using Unsigned = unsigned __int128;
    /// Wraps: no rendering comes near the limits, but a file that somebody made may hold any sum.
    void addUnits(Integer term) {
        units_ = static_cast<Integer>(static_cast<Unsigned>(units_) + static_cast<Unsigned>(term));
    }
    Integer units_ = 0;
};

/// What a pixel has received in all passes.
struct PixelSum {
    /// Largest value of a pass. No sum overflows in 2^27 passes.
    static constexpr double kLargest = 0x1p36;

    ExactSum<63> color[3];
    /// Of the luminances of the passes: two ranges, as squares span twice the orders of magnitude.
    ExactSum<100> faintSquares;
    ExactSum<26> brightSquares;

    void addSquare(double square) { square < 1 ? faintSquares.add(square) : brightSquares.add(square); }
    double squares() const { return faintSquares.value() + brightSquares.value(); }
    PixelSum& operator+=(const PixelSum& other) {
        for (int c = 0; c < 3; ++c) color[c] += other.color[c];
        faintSquares += other.faintSquares;
        brightSquares += other.brightSquares;
        return *this;
    }
    template <class Archive>
    void serialize(Archive& archive) {
        archive(color[0], color[1], color[2], faintSquares, brightSquares);
    }
};

}  // namespace metrolux::core
