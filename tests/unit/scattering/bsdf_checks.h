#pragma once
/// Checks that every Bsdf has to pass; `checkBsdf(BsdfCase)` runs them all for a set of known directions in
/// both transport modes. Each check can be called alone.
///
/// Error rate: the chi-square tests share one budget. With kTotalErrorRate and kMaxTests the Sidak level of
/// one test is 1 - (1 - kTotalErrorRate)^(1 / kMaxTests), so that a correct program of at most kMaxTests
/// tests fails with a probability below kTotalErrorRate (checkBsdf counts, and fails beyond). Seeds are
/// fixed: an outcome is repeatable. The energy test allows five standard errors above the bound (1.5e-7 or
/// less for each).

#include "base/error.h"
#include "base/rng.h"
#include "base/warp.h"
#include "scattering/bsdf.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace metrolux::core::test {

inline constexpr double kTotalErrorRate = 1e-3;
inline constexpr int kMaxTests = 4000;
inline constexpr int kChiSquareSamples = 40000;

/// A point on the plane z = 0 with the world axes as its shading frame.
inline SurfaceInteraction flatInteraction(const Vec2f& uv = {0.3f, 0.6f}) {
    SurfaceInteraction si;
    si.p = Vec3f(0, 0, 0);
    si.ng = si.ns = Vec3f(0, 0, 1);
    si.s = Vec3f(1, 0, 0);
    si.uv = uv;
    si.barycentric = Vec2f(0.2f, 0.3f);
    return si;
}

/// A model with what is known about it.
struct BsdfCase {
    std::string name;
    BsdfPtr bsdf;
    bool reciprocal = true;  ///< f(a,b) = f(b,a) (times the eta^2 ratio)
    bool conservesAdjoint =
        true;  ///< importance energy <= 1 in the unperturbed frame (not with a perturbed normal)
    SurfaceInteraction si = flatInteraction();
};

/// Normal, oblique and grazing directions on both sides.
inline std::vector<Vec3f> knownDirections() {
    std::vector<Vec3f> result;
    for (const float side : {1.0f, -1.0f}) {
        result.push_back({0, 0, side});
        for (const auto& [cosine, phi] : {std::pair{0.8f, 0.7f}, {0.4f, 2.9f}, {0.06f, 4.4f}}) {
            const float sine = std::sqrt(1 - cosine * cosine);
            result.push_back({sine * std::cos(phi), sine * std::sin(phi), side * cosine});
        }
    }
    return result;
}

inline std::string describe(const BsdfCase& c, const Vec3f& known, TransportMode mode) {
    return fmt::format("{}, known ({:.3f} {:.3f} {:.3f}), {}", c.name, known.x, known.y, known.z,
                       mode == TransportMode::Radiance ? "radiance" : "importance");
}

/// Density of sample() in the mode for a pair (known, other), zero where the value is black: there sample()
/// returns nothing, which is a legal sample of value zero.
inline float visibleDensity(const BsdfCase& c, const Vec3f& known, const Vec3f& other, TransportMode mode) {
    const bool radiance = mode == TransportMode::Radiance;
    const BsdfEvaluation e =
        radiance ? c.bsdf->evaluate(c.si, known, other) : c.bsdf->evaluate(c.si, other, known);
    return isBlack(e.value) ? 0.0f : radiance ? e.pdfLight : e.pdfEye;
}

/// Integral of f over the rectangle [x0,x1] x [y0,y1]: Gauss-Legendre (4 x 4), halved in both axes until two
/// levels agree.
inline double adaptiveQuadrature(const std::function<double(double, double)>& f, double x0, double x1,
                                 double y0, double y1, double tolerance, int minDepth, int maxDepth) {
    static constexpr std::array<double, 4> kNode = {-0.8611363115940526, -0.3399810435848563,
                                                    0.3399810435848563, 0.8611363115940526};
    static constexpr std::array<double, 4> kWeight = {0.3478548451374538, 0.6521451548625461,
                                                      0.6521451548625461, 0.3478548451374538};
    const auto rule = [&](double a, double b, double c, double d) {
        double sum = 0;
        for (size_t i = 0; i < 4; ++i)
            for (size_t j = 0; j < 4; ++j)
                sum += kWeight[i] * kWeight[j] *
                       f(0.5 * (a + b) + 0.5 * (b - a) * kNode[i], 0.5 * (c + d) + 0.5 * (d - c) * kNode[j]);
        return 0.25 * (b - a) * (d - c) * sum;
    };
    const std::function<double(double, double, double, double, double, int)> refine =
        [&](double a, double b, double c, double d, double whole, int depth) {
            const double x = 0.5 * (a + b), y = 0.5 * (c + d);
            const std::array<std::array<double, 4>, 4> parts = {
                {{a, x, c, y}, {x, b, c, y}, {a, x, y, d}, {x, b, y, d}}};
            std::array<double, 4> value{};
            double sum = 0;
            for (size_t i = 0; i < 4; ++i)
                sum += value[i] = rule(parts[i][0], parts[i][1], parts[i][2], parts[i][3]);
            if (depth >= maxDepth || (depth >= minDepth && std::abs(sum - whole) < tolerance)) return sum;
            double refined = 0;
            for (size_t i = 0; i < 4; ++i)
                refined += refine(parts[i][0], parts[i][1], parts[i][2], parts[i][3], value[i], depth + 1);
            return refined;
        };
    return refine(x0, x1, y0, y1, rule(x0, x1, y0, y1), 1);
}

/// A delta lobe as sample() showed it.
struct DeltaLobe {
    Vec3f direction;
    BsdfSample sample;
    double count = 0;
};

/// (a) Chi-square test of sample() against its densities: bins over the sphere (uniform in cos theta and
/// phi), one for each delta lobe, one for "nothing".
inline void checkSampling(const BsdfCase& c, const Vec3f& known, TransportMode mode, uint64_t seed) {
    constexpr int kRows = 20, kColumns = 40;  // an even number of rows: no bin crosses the horizon
    static int testsRun = 0;
    ASSERT_LE(++testsRun, kMaxTests) << "raise kMaxTests: the stated error rate no longer holds";
    SCOPED_TRACE(describe(c, known, mode));

    std::vector<double> observed(kRows * kColumns, 0.0), expected(kRows * kColumns, 0.0);
    std::vector<DeltaLobe> deltas;
    double nothing = 0;
    CounterRng rng(hashKey(seed, 1));
    for (int i = 0; i < kChiSquareSamples; ++i) {
        const float uLobe = rng.next1D();
        const auto sample = c.bsdf->sample(c.si, known, mode, uLobe, rng.next2D());
        if (!sample) {
            ++nothing;
        } else if (sample->delta) {
            auto lobe = deltas.begin();
            while (lobe != deltas.end() && (lobe->direction - sample->direction).length() > 1e-3f) ++lobe;
            if (lobe == deltas.end()) lobe = deltas.insert(lobe, {sample->direction, *sample, 0});
            ++lobe->count;
        } else {
            const Vec3f d = sample->direction;
            const float phi = std::atan2(d.y, d.x) + (d.y < 0 ? 2 * kPi : 0);
            const int row = std::clamp(static_cast<int>((d.z + 1) * 0.5f * kRows), 0, kRows - 1);
            const int column = std::clamp(static_cast<int>(phi / (2 * kPi) * kColumns), 0, kColumns - 1);
            ++observed[static_cast<size_t>(row * kColumns + column)];
        }
    }

    const auto density = [&](double z, double phi) {
        const double r = std::sqrt(std::max(0.0, 1 - z * z));
        const Vec3f other(static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
                          static_cast<float>(z));
        return static_cast<double>(visibleDensity(c, known, other, mode));
    };
    double mass = 0;
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column)
            mass += expected[static_cast<size_t>(row * kColumns + column)] = adaptiveQuadrature(
                density, 2.0 * row / kRows - 1, 2.0 * (row + 1) / kRows - 1, 2.0 * kPi * column / kColumns,
                2.0 * kPi * (column + 1) / kColumns, 2e-6, 1, 7);
    for (const DeltaLobe& lobe : deltas) {
        observed.push_back(lobe.count);
        expected.push_back(lobe.sample.pdfForward);
        mass += lobe.sample.pdfForward;
    }
    EXPECT_LE(mass, 1 + 2e-3) << "delta lobes and smooth density integrate to more than one";
    observed.push_back(nothing);
    expected.push_back(std::max(0.0, 1 - mass));

    double statistic = 0, pooledObserved = 0, pooledExpected = 0;
    int cells = 0;
    const auto add = [&](double o, double e) {
        statistic += (o - e) * (o - e) / e;
        ++cells;
    };
    for (size_t i = 0; i < observed.size(); ++i) {
        const double e = expected[i] * kChiSquareSamples;
        if (e >= 5) {
            add(observed[i], e);
        } else {
            pooledObserved += observed[i];
            pooledExpected += e;
        }
    }
    if (pooledExpected >= 5)
        add(pooledObserved, pooledExpected);
    else
        EXPECT_LE(pooledObserved, pooledExpected + 30) << "samples where the density is (almost) zero";
    if (cells < 2) return;
    const double level = 1 - std::pow(1 - kTotalErrorRate, 1.0 / kMaxTests);
    const double limit = boost::math::quantile(
        boost::math::complement(boost::math::chi_squared_distribution<double>(cells - 1), level));
    EXPECT_LE(statistic, limit) << "chi-square with " << cells - 1 << " degrees of freedom; mass " << mass;
}

/// Compares with a relative tolerance; `scale` is added to the magnitude so that noise near zero does not
/// count.
inline void expectClose(double a, double b, double tolerance, const char* what, double scale = 1e-4) {
    EXPECT_LE(std::abs(a - b), tolerance * (std::max(std::abs(a), std::abs(b)) + scale))
        << what << ": " << a << " against " << b;
}

/// (b) A smooth sample says the same as evaluate(): weight = S / pdf, both densities, transmission, unit
/// direction. (d) S(a,b) / |cos b| * eta^2 = S(b,a) / |cos a| for reciprocal models; eta is that of `b` over
/// that of `a`.
inline void checkEvaluation(const BsdfCase& c, const Vec3f& known, TransportMode mode, uint64_t seed,
                            int samples = 400) {
    SCOPED_TRACE(describe(c, known, mode));
    const bool radiance = mode == TransportMode::Radiance;
    CounterRng rng(hashKey(seed, 2));
    for (int i = 0; i < samples && !::testing::Test::HasFailure(); ++i) {
        const float uLobe = rng.next1D();
        const auto s = c.bsdf->sample(c.si, known, mode, uLobe, rng.next2D());
        if (!s) continue;
        const Vec3f d = s->direction;
        ASSERT_TRUE(isFinite(d) && isFinite(s->weight) && std::isfinite(s->pdfForward) &&
                    std::isfinite(s->pdfReverse));
        EXPECT_NEAR(d.length(), 1, 2e-4);
        EXPECT_GE(std::min({s->weight.x, s->weight.y, s->weight.z}), 0);
        EXPECT_GT(s->pdfForward, 0);
        EXPECT_GE(s->pdfReverse, 0);
        EXPECT_EQ(s->transmitted, known.z * d.z < 0) << "transmitted disagrees with the directions";
        EXPECT_GT(s->eta, 0);
        EXPECT_TRUE(s->transmitted || s->eta == 1);
        EXPECT_TRUE(!s->transmitted || c.bsdf->isTransmissive());
        EXPECT_TRUE(s->delta ? c.bsdf->hasDeltaLobe() : c.bsdf->hasSmoothLobe());
        if (s->delta) continue;

        const Vec3f wEye = radiance ? known : d, wLight = radiance ? d : known;
        const BsdfEvaluation e = c.bsdf->evaluate(c.si, wEye, wLight);
        expectClose(s->pdfForward, radiance ? e.pdfLight : e.pdfEye, 1e-3, "pdfForward");
        expectClose(s->pdfReverse, radiance ? e.pdfEye : e.pdfLight, 1e-3, "pdfReverse");
        for (int k = 0; k < 3; ++k)
            expectClose(static_cast<double>(s->weight[k]) * s->pdfForward, e.value[k], 1e-3,
                        "weight * pdf against S");
        if (!c.reciprocal) continue;
        const BsdfEvaluation swapped = c.bsdf->evaluate(c.si, wLight, wEye);
        const double eta = radiance ? s->eta : 1 / s->eta;
        for (int k = 0; k < 3; ++k)
            expectClose(e.value[k] / absCosTheta(wLight) * eta * eta, swapped.value[k] / absCosTheta(wEye),
                        5e-3, "reciprocity", 1e-3);
    }
}

/// (c) No more energy leaves than arrives: the mean of the weights, freed of the radiance scaling by eta^2
/// and (for importance) of the ratio of the cosines, is at most 1 in each channel.
inline void checkEnergy(const BsdfCase& c, const Vec3f& known, TransportMode mode, uint64_t seed,
                        int samples = 20000) {
    SCOPED_TRACE(describe(c, known, mode));
    const bool radiance = mode == TransportMode::Radiance;
    if (!radiance && !c.conservesAdjoint) return;
    std::array<double, 3> sum{}, sumSquares{};
    CounterRng rng(hashKey(seed, 3));
    for (int i = 0; i < samples; ++i) {
        const float uLobe = rng.next1D();
        const auto s = c.bsdf->sample(c.si, known, mode, uLobe, rng.next2D());
        if (!s) continue;
        const double scale = radiance ? sqr(s->eta) : absCosTheta(s->direction) / absCosTheta(known);
        for (int k = 0; k < 3; ++k) {
            sum[static_cast<size_t>(k)] += scale * s->weight[k];
            sumSquares[static_cast<size_t>(k)] += sqr(scale * s->weight[k]);
        }
    }
    for (size_t k = 0; k < 3; ++k) {
        const double mean = sum[k] / samples;
        const double error = std::sqrt(std::max(0.0, sumSquares[k] / samples - mean * mean) / samples);
        EXPECT_LE(mean, 1 + 1e-3 + 5 * error) << "energy in channel " << k;
    }
    const Rgb albedo = c.bsdf->albedo(c.si);
    for (int k = 0; k < 3; ++k) {
        EXPECT_GE(albedo[k], 0);
        EXPECT_LE(albedo[k], 1);
        EXPECT_TRUE(albedo[k] > 0 || sum[static_cast<size_t>(k)] < 1e-6 * samples)
            << "albedo is black, channel " << k;
    }
}

/// (e) A delta lobe seen from its other end: sampled there in the other mode it has the two probabilities
/// exchanged and carries the same energy. Weight conventions: Bsdf::deltaWeight.
inline void checkDelta(const BsdfCase& c, const Vec3f& known, TransportMode mode, uint64_t seed) {
    SCOPED_TRACE(describe(c, known, mode));
    const auto other = mode == TransportMode::Radiance ? TransportMode::Importance : TransportMode::Radiance;
    const auto energy = [](const BsdfSample& s, const Vec3f& from, TransportMode m) {
        const float scale =
            m == TransportMode::Radiance ? sqr(s.eta) : absCosTheta(s.direction) / absCosTheta(from);
        return s.weight * (s.pdfForward * scale);
    };
    CounterRng rng(hashKey(seed, 4));
    for (int i = 0; i < 60 && !::testing::Test::HasFailure(); ++i) {
        const float uLobe = rng.next1D();
        const auto forward = c.bsdf->sample(c.si, known, mode, uLobe, rng.next2D());
        if (!forward || !forward->delta || !(forward->pdfReverse > 0.02f)) continue;
        EXPECT_LE(forward->pdfForward, 1 + 1e-5);
        EXPECT_LE(forward->pdfReverse, 1 + 1e-5);
        std::optional<BsdfSample> back;
        for (int k = 0; k < 2000 && !back; ++k) {
            const float u = rng.next1D();
            back = c.bsdf->sample(c.si, forward->direction, other, u, rng.next2D());
            if (back && (!back->delta || (back->direction - known).length() > 2e-3f)) back.reset();
        }
        ASSERT_TRUE(back) << "a delta lobe with pdfReverse " << forward->pdfReverse
                          << " is not sampled from its other end";
        EXPECT_NEAR(back->pdfForward, forward->pdfReverse, 2e-3);
        EXPECT_NEAR(back->pdfReverse, forward->pdfForward, 2e-3);
        EXPECT_NEAR(back->eta * forward->eta, 1, 1e-4);
        if (!c.conservesAdjoint) continue;  // the cosines are those of another frame
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(energy(*back, forward->direction, other)[k], energy(*forward, known, mode)[k], 3e-3);
    }
}

/// All checks, both modes, all known directions.
inline void checkBsdf(const BsdfCase& c, uint64_t seed = 1) {
    for (const Vec3f& known : knownDirections()) {
        for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance}) {
            checkEvaluation(c, known, mode, ++seed);
            checkDelta(c, known, mode, ++seed);
            checkEnergy(c, known, mode, ++seed);
            checkSampling(c, known, mode, ++seed);
            if (::testing::Test::HasFailure()) return;
        }
    }
}

}  // namespace metrolux::core::test
