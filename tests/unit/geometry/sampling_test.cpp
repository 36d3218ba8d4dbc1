// Uniformity of sampleArea, and the densities of sampleToward.
#include "support.h"

#include <boost/math/distributions/chi_squared.hpp>

#include <functional>

namespace metrolux::core {
namespace {

/// Samples counted in cells of equal area must pass a chi-square test. Error rate 1e-6 for each shape; seeds
/// are fixed.
void expectUniform(const Shape& shape, int cells,
                   const std::function<int(const SurfaceInteraction&)>& cellOf) {
    constexpr int kSamples = 200000;
    std::vector<int> counts(static_cast<size_t>(cells));
    CounterRng rng(hashKey(11));
    for (int i = 0; i < kSamples; ++i) {
        const int cell = cellOf(shape.sampleArea(rng.next2D()).si);
        ASSERT_TRUE(cell >= 0 && cell < cells);
        ++counts[static_cast<size_t>(cell)];
    }
    const double expected = double(kSamples) / cells;
    double chi2 = 0;
    for (const int n : counts) chi2 += (n - expected) * (n - expected) / expected;
    const double limit = quantile(complement(boost::math::chi_squared(cells - 1), 1e-6));
    EXPECT_LT(chi2, limit);
}

int grid(double x, double y, int n) {
    return std::clamp(int(x * n), 0, n - 1) * n + std::clamp(int(y * n), 0, n - 1);
}

TEST(ShapeSampling, IsUniformOverTheArea) {
    expectUniform(*makeSphere(similarity(), {1, 2, 3}, 2, false), 100, [](const SurfaceInteraction& si) {
        return grid(si.uv.x, 0.5 - 0.5 * std::cos(double(kPi) * si.uv.y), 10);  // Archimedes
    });
    expectUniform(*makeDisk(similarity(), false), 100,
                  [](const SurfaceInteraction& si) { return grid(sqr(si.uv.x), si.uv.y, 10); });
    expectUniform(*makeCylinder(similarity(), {1, 0, 0}, {0, 2, 0}, 0.3f, false), 100,
                  [](const SurfaceInteraction& si) { return grid(si.uv.x, si.uv.y, 10); });
    expectUniform(*makeRectangle(similarity(), false), 100,
                  [](const SurfaceInteraction& si) { return grid(si.uv.x, si.uv.y, 10); });
    expectUniform(*makeCube(similarity(), false), 150, [](const SurfaceInteraction& si) {
        return int(si.primitive / 2) * 25 + grid(si.uv.x, si.uv.y, 5);
    });
}

TEST(ShapeSampling, TrianglesAreChosenByArea) {
    TriangleMesh mesh;
    // A triangle of zero area, then areas 1 : 3.
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {8, 0, 0}, {5, 1, 0}};
    mesh.indices = {0, 1, 1, 0, 1, 2, 3, 4, 5};
    mesh.finalize();
    EXPECT_NEAR(mesh.area(), 2, 1e-6);
    CounterRng rng(hashKey(12));
    int counts[3] = {};
    constexpr int kSamples = 100000;
    for (int i = 0; i < kSamples; ++i) ++counts[mesh.sampleArea(rng.next2D()).si.primitive];
    EXPECT_EQ(counts[0], 0);
    // Five standard deviations: error rate 6e-7.
    EXPECT_NEAR(counts[1], kSamples / 4.0, 5 * std::sqrt(kSamples * 0.25 * 0.75));
    for (const float u : {0.0f, kOneMinusEpsilon}) EXPECT_NE(mesh.sampleArea({u, u}).si.primitive, 0u);
}

/// pdfToward integrates to one over the shape, estimated with uniform samples; tolerance five standard
/// errors.
TEST(ShapeSampling, PdfTowardIsNormalized) {
    const Vec3f references[] = {{0, 0, 3}, {0, 0, 1.05f}, {20, -30, 10}, {0.1f, 0.2f, 0.3f}, {0, 0, 0}};
    for (const bool flip : {false, true})
        for (const ShapePtr& shape :
             {makeSphere(Transform(), {0, 0, 0}, 1, flip), makeDisk(similarity(), flip)})
            for (const Vec3f& reference : references) {
                CounterRng rng(hashKey(13));
                double sum = 0, squares = 0;
                constexpr int kSamples = 100000;
                for (int i = 0; i < kSamples; ++i) {
                    const ShapeSample s = shape->sampleArea(rng.next2D());
                    const double x = shape->pdfToward(reference, s.si) / s.pdfArea;
                    sum += x, squares += x * x;
                }
                const double mean = sum / kSamples;
                const double error = std::sqrt((squares / kSamples - mean * mean) / kSamples);
                EXPECT_NEAR(mean, 1, 5 * error + 1e-4);
            }
}

TEST(ShapeSampling, SphereIsSampledUniformlyInItsCone) {
    for (const float distance : {1.001f, 1.5f, 10.0f, 1e3f, 1e5f}) {
        SCOPED_TRACE(distance);
        const ShapePtr sphere = makeSphere(Transform(), {0, 0, 0}, 1, false);
        const Vec3f reference = normalize(Vec3f(1, 2, -3)) * distance;
        const double sin2Max = 1.0 / (double(distance) * distance);
        const double oneMinusCosMax = sin2Max / (1 + std::sqrt(1 - sin2Max));
        const double pdfSolidAngle = 1 / (2 * std::numbers::pi * oneMinusCosMax);
        constexpr int kBins = 20, kSamples = 20000;
        int counts[kBins] = {}, lost = 0;
        CounterRng rng(hashKey(14));
        for (int i = 0; i < kSamples; ++i) {
            const auto s = sphere->sampleToward(reference, rng.next2D());
            if (!s) {
                ++lost;
                continue;
            }
            EXPECT_NEAR(s->si.p.length(), 1, 1e-6);
            const Vec3f w = s->si.p - reference;
            const double distance2 = lengthSquared(w), cosine = -dot(w, s->si.ng) / std::sqrt(distance2);
            ASSERT_GT(cosine, 0);  // visible
            EXPECT_EQ(s->pdfArea, sphere->pdfToward(reference, s->si));
            if (cosine > 1e-2) {
                EXPECT_NEAR(s->pdfArea * distance2 / cosine / pdfSolidAngle, 1, 1e-3);
            }
            // The angle to the axis, by the sine: that keeps its precision for narrow cones.
            const double sin2 = w.cross(reference).length2() / (distance2 * double(lengthSquared(reference)));
            const double oneMinusCos = sin2 / (1 + std::sqrt(1 - sin2));
            ++counts[std::clamp(int(oneMinusCos / oneMinusCosMax * kBins), 0, kBins - 1)];
        }
        EXPECT_LT(lost, kSamples / 1000);
        double chi2 = 0;
        for (const int n : counts) chi2 += sqr(n - double(kSamples) / kBins) / (double(kSamples) / kBins);
        EXPECT_LT(chi2, quantile(complement(boost::math::chi_squared(kBins - 1), 1e-6)));
    }
}

}  // namespace
}  // namespace metrolux::core
