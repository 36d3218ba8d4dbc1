#include "scattering/wavelength.h"

#include "base/rng.h"
#include "scattering/cie1931.h"

#include <algorithm>
#include <array>

namespace metrolux::core {
namespace {

/// The density of wavelengths, constant within cells of 1 nm, and the scale of their colors.
struct Spectrum {
    static constexpr int kCells = Wavelength::kLast - Wavelength::kFirst;
    Rgb white;                           ///< integral of the colors over all wavelengths
    std::array<double, kCells + 1> cdf;  ///< at the borders of the cells

    Spectrum() {
        // The observer is linear within a cell: its value at the center is its mean.
        std::array<Rgb, kCells> colors;
        std::array<double, 3> sum{};
        for (int i = 0; i < kCells; ++i) {
            colors[static_cast<size_t>(i)] = rec709Of(cieObserver(Wavelength::kFirst + i + 0.5));
            for (int c = 0; c < 3; ++c) sum[static_cast<size_t>(c)] += colors[static_cast<size_t>(i)][c];
        }
        white = {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
        // In proportion to the sum of the channels' magnitudes, so that each is bounded by the same.
        cdf[0] = 0;
        for (size_t i = 0; i < kCells; ++i) {
            const Rgb c = colors[i] / white;
            cdf[i + 1] = cdf[i] + std::abs(double(c.x)) + std::abs(double(c.y)) + std::abs(double(c.z));
        }
        for (double& x : cdf) x /= cdf[kCells];
    }
};

const Spectrum& spectrum() {
    static const Spectrum instance;
    return instance;
}

}  // namespace

Wavelength Wavelength::at(double u) {
    const Spectrum& s = spectrum();
    const auto above = std::upper_bound(s.cdf.begin(), s.cdf.end() - 1, u);
    const auto i = static_cast<size_t>(above - s.cdf.begin()) - 1;
    const double density = s.cdf[i + 1] - s.cdf[i];
    const double nanometers = kFirst + double(i) + std::clamp((u - s.cdf[i]) / density, 0.0, 1.0);
    return {static_cast<float>(nanometers),
            rec709Of(cieObserver(nanometers)) / s.white * static_cast<float>(1 / density)};
}

Wavelength Wavelength::ofPass(uint64_t seed, uint32_t pass) {
    constexpr uint64_t kPurpose = 0x776176656c656e;
    // Multiples of the golden ratio, modulo 1: evenly spread for any number of passes, and out of step with
    // the powers of two in which other coordinates of the passes are.
    constexpr uint64_t kGolden = 0x9e3779b97f4a7c15;
    const uint64_t position = hashKey(seed, kPurpose) + pass * kGolden;
    return at(static_cast<double>(position >> 11) * 0x1p-53);
}

}  // namespace metrolux::core
