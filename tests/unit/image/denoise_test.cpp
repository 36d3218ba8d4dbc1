#include "image/denoise.h"

#include "base/math.h"
#include "base/rng.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace metrolux::core {
namespace {

/// Passes of an image whose pixels have noise, which is even unless a test says otherwise.
class Rendering {
  public:
    static constexpr int kWidth = 70, kHeight = 45;
    static constexpr uint32_t kPasses = 16;
    static constexpr size_t kPixels = size_t{kWidth} * kHeight;

    /// `color` of a pixel, `noise`: relative standard deviation of a pass.
    Rendering(const std::function<float(int, int)>& color, float noise)
        : truth(3 * kPixels),
          first(3 * kPixels),
          second(3 * kPixels),
          mean(3 * kPixels),
          variance(kPixels),
          albedo(3 * kPixels, 0.5f),
          normal(3 * kPixels),
          inverseDistance(kPixels, 0.25f) {
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const auto i = static_cast<size_t>(y * kWidth + x);
                normal[3 * i + 2] = 1;
                CounterRng rng(hashKey(1, x, y));
                double sum[2] = {}, squares = 0;
                const auto value = double(color(x, y));
                for (uint32_t pass = 0; pass < kPasses; ++pass) {
                    const double sample =
                        value * (1 + double(noise) * std::sqrt(12.0) * (rng.nextDouble() - 0.5));
                    sum[pass % 2] += sample;
                    squares += sample * sample;
                }
                const double average = (sum[0] + sum[1]) / kPasses;
                variance[i] =
                    static_cast<float>(std::max(0.0, squares / kPasses - average * average) / (kPasses - 1));
                for (size_t c = 0; c < 3; ++c) {
                    truth[3 * i + c] = static_cast<float>(value);
                    first[3 * i + c] = static_cast<float>(sum[0] * 2 / kPasses);
                    second[3 * i + c] = static_cast<float>(sum[1] * 2 / kPasses);
                    mean[3 * i + c] = static_cast<float>(average);
                }
            }
    }
    std::vector<float> denoised() const {
        return denoise({kWidth, kHeight, mean, first, second, variance, kPasses / 2, kPasses, albedo, normal,
                        inverseDistance});
    }
    /// Mean squared error of pixels for which `where` holds.
    double error(
        const std::vector<float>& image,
        const std::function<bool(int)>& where = [](int) { return true; }) const {
        double sum = 0;
        int count = 0;
        for (size_t i = 0; i < kPixels; ++i) {
            if (!where(static_cast<int>(i) % kWidth)) continue;
            sum += sqr(double(image[3 * i]) - double(truth[3 * i]));
            ++count;
        }
        return sum / count;
    }
    void setPixel(size_t i, float a, float b, float pixelVariance) {
        for (size_t c = 0; c < 3; ++c) {
            first[3 * i + c] = a, second[3 * i + c] = b;
            mean[3 * i + c] = a / 2 + b / 2;
        }
        variance[i] = pixelVariance;
    }

    std::vector<float> truth, first, second, mean, variance, albedo, normal, inverseDistance;
};

TEST(Denoise, AConstantImageStays) {
    for (const float value : {0.0f, 1e-12f, 0.3f, 1e20f}) {
        const Rendering rendering([&](int, int) { return value; }, 0);
        for (const float x : rendering.denoised()) ASSERT_NEAR(x / std::max(value, 1e-30f), value > 0, 1e-4);
    }
}

TEST(Denoise, NoiseOnAPlaneFalls) {
    const Rendering rendering([](int x, int y) { return 0.2f + 0.002f * float(x) + 0.001f * float(y); },
                              0.4f);
    const double plain = rendering.error(rendering.mean);
    // A first-order fit in a window of some 100 effective pixels, ten features of which three vary.
    EXPECT_LT(rendering.error(rendering.denoised()), plain / 15);
}

TEST(Denoise, AnEdgeThatNoFeatureHasIsKept) {
    const Rendering rendering([](int x, int) { return x < 35 ? 0.1f : 1.0f; }, 0.3f);
    const std::vector<float> result = rendering.denoised();
    EXPECT_LT(rendering.error(result), rendering.error(rendering.mean) / 4);
    // Beside the edge a blur of 1 % of the step would be 9e-3.
    const auto atEdge = [](int x) { return x == 34 || x == 35; };
    EXPECT_LT(rendering.error(result, atEdge), rendering.error(rendering.mean, atEdge));
    double dark = 0, bright = 0;
    for (size_t y = 0; y < Rendering::kHeight; ++y) {
        dark += double(result[3 * (y * Rendering::kWidth + 34)]) / Rendering::kHeight;
        bright += double(result[3 * (y * Rendering::kWidth + 35)]) / Rendering::kHeight;
    }
    EXPECT_NEAR(dark, 0.1, 0.01);
    EXPECT_NEAR(bright, 1, 0.02);
}

TEST(Denoise, WhatAlbedoExplainsIsKept) {
    Rendering rendering([](int x, int y) { return (x / 3 + y / 3) % 2 ? 0.2f : 0.3f; }, 0.4f);
    for (size_t i = 0; i < rendering.albedo.size(); ++i) rendering.albedo[i] = rendering.truth[i];
    EXPECT_LT(rendering.error(rendering.denoised()), rendering.error(rendering.mean) / 10);
}

TEST(Denoise, AnOutlierIsNotSpread) {
    Rendering rendering([](int, int) { return 0.5f; }, 0.2f);
    const size_t outlier = size_t{20} * Rendering::kWidth + 30;
    rendering.setPixel(outlier, 1000, 0.5f, sqr(500.0f));
    const std::vector<float> result = rendering.denoised();
    for (size_t i = 0; i < Rendering::kPixels; ++i) {
        if (i == outlier) continue;
        ASSERT_NEAR(result[3 * i], 0.5f, 0.2f) << i % Rendering::kWidth << ", " << i / Rendering::kWidth;
    }
}

TEST(Denoise, ResultsAreFinite) {
    Rendering rendering([](int x, int y) { return (x + y) % 7 ? 1e-20f * float(x) : 3.0f; }, 1);
    constexpr float kLargest = std::numeric_limits<float>::max();
    rendering.setPixel(100, kLargest, 0, kLargest);
    rendering.setPixel(500, 0, 0, 0);
    rendering.setPixel(900, -1, 2, kLargest);
    rendering.normal[17] = 1e30f;
    for (const float x : rendering.denoised()) ASSERT_TRUE(std::isfinite(x));
}

TEST(Denoise, ThreadsChangeNothing) {
    const Rendering rendering([](int x, int y) { return 0.1f + float(x * y % 11); }, 0.3f);
    const auto with = [&](size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return rendering.denoised();
    };
    EXPECT_EQ(with(1), with(2));
}

TEST(Denoise, OnePixel) {
    const std::vector<float> color{0.2f, 0.3f, 0.4f}, one{1.0f};
    EXPECT_EQ(denoise({1, 1, color, color, color, one, 1, 2, color, color, one}).size(), 3u);
}

}  // namespace
}  // namespace metrolux::core
