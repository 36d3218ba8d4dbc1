#include "image/film.h"

#include "base/error.h"
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "image/fixed_point.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <limits>
#include <numeric>
#include <thread>

namespace metrolux::core {
namespace {

using Kind = ReconstructionFilter::Kind;

FilmWindow window(int width, int height) { return {width, height, 0, 0, width, height}; }

/// Splats over many orders of magnitude, positive and negative (filters have negative lobes).
std::vector<SplatList> randomSplats(int lists, int pixels, int side) {
    std::vector<SplatList> result(static_cast<size_t>(lists));
    CounterRng rng(hashKey(1, 2));
    const auto value = [&] {
        const float size = std::exp2(60 * rng.next1D() - 40);
        return Rgb(size * rng.next1D(), -size * rng.next1D(), size * rng.next1D());
    };
    for (SplatList& list : result) {
        for (int i = 0; i < 3; ++i)
            list.pixels.push_back(
                {static_cast<uint32_t>(rng.next1D() * static_cast<float>(pixels)), value()});
        list.film.push_back({rng.next2D() * static_cast<float>(side), value()});
    }
    return result;
}

TEST(Film, SumDoesNotDependOnOrderOrThreads) {
    const auto splats = randomSplats(20000, 64, 8);
    std::vector<size_t> order(splats.size());
    std::iota(order.begin(), order.end(), size_t{0});
    const auto render = [&](int threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<size_t>(threads));
        Film film(window(8, 8), ReconstructionFilter(Kind::Lanczos, {}));
        parallelFor(order.size(), [&](size_t i) { film.addSplats(splats[order[i]], 0.37); });
        film.endPass();
        return film.image();
    };
    const auto reference = render(1);
    CounterRng rng(3);
    for (size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[rng.nextBits() % (i + 1)]);
    EXPECT_EQ(reference, render(1));
    EXPECT_EQ(reference, render(2));
    EXPECT_NE(reference, std::vector<float>(reference.size(), 0.0f));
}

TEST(Film, KeepsFifteenOrdersOfMagnitude) {
    Film film(window(3, 1), ReconstructionFilter(Kind::Box, {}));
    SplatList faint, bright;
    faint.pixels.push_back({0, Rgb(1e-9f)});
    bright.pixels.push_back({1, Rgb(1e6f)});
    bright.pixels.push_back({2, Rgb(3e10f)});
    film.addSplats(faint, 1);
    film.addSplats(bright, 1);
    film.endPass();
    const auto image = film.image();
    EXPECT_NEAR(image[0] / 1e-9, 1, 1e-6);
    EXPECT_NEAR(image[3] / 1e6, 1, 1e-6);
    EXPECT_NEAR(image[6] / 3e10, 1, 1e-6);
}

TEST(Film, FaintLightIsNotLostBesideBrightLight) {
    FixedPointImage sum(1, 1);
    for (int i = 0; i < 1000; ++i) {
        ASSERT_TRUE(sum.add(0, Rgb(1e-9f), 1));
        ASSERT_TRUE(sum.add(0, Rgb(1e6f), 1));
        ASSERT_TRUE(sum.add(0, Rgb(-1e6f), 1));
    }
    EXPECT_NEAR(sum.take(0)[0], 1e-6, 1e-11);
    EXPECT_EQ(sum.take(0)[0], 0);
}

/// As many as an image of 4096x4096 pixels has light subpaths, all in one pixel.
TEST(FixedPointImage, NoSumWrapsHoweverManyTermsAPixelGets) {
    constexpr int kTerms = 4096 * 4096, kWidth = 40;
    constexpr size_t kPixel = 35;  // not in the first tile
    FixedPointImage sums(kWidth, 2);
    // The largest of each range, and the same below zero.
    constexpr double kSizes[] = {FixedPointImage::kLargest, 0x1.fp11, 0x1.fp-13};
    for (const double size : kSizes) {
        const Rgb value(static_cast<float>(size), static_cast<float>(-size), 0);
        for (int i = 0; i < kTerms; ++i) ASSERT_TRUE(sums.add(kPixel, value, 1));
        sums.add(kPixel + kWidth, value, 1);
        const std::array<double, 3> sum = sums.take(kPixel), beside = sums.take(kPixel + kWidth);
        EXPECT_EQ(sum, (std::array<double, 3>{size * kTerms, -size * kTerms, 0}));
        EXPECT_EQ(beside, (std::array<double, 3>{size, -size, 0}));
        EXPECT_EQ(sums.take(kPixel), (std::array<double, 3>{}));
    }
    // Products take rows as vectors.
    const float weight = 1;
    for (int i = 0; i < kTerms; ++i)
        ASSERT_TRUE(sums.addProduct(kPixel, 0, {&weight, 1}, {&weight, 1}, Rgb(0x1.fp11f), 1));
    EXPECT_EQ(sums.take(kPixel)[0], 0x1.fp11 * kTerms);
}

TEST(Film, TheExponentIsThatOfImageAndVariance) {
    const ReconstructionFilter box(Kind::Box, {});
    Film plain(window(2, 1), box), scaled(window(2, 1), box, 50), tooBright(window(2, 1), box, 127),
        tooDark(window(2, 1), box, -140);
    for (Film* film : {&plain, &scaled, &tooBright, &tooDark})
        for (const float y : {1.0f, 3.0f, 5.0f}) {
            film->addEye(0, Rgb(y, 2 * y, 0));
            film->endPass();
        }
    for (size_t i = 0; i < 6; ++i) EXPECT_EQ(scaled.image()[i], std::ldexp(plain.image()[i], 50));
    for (size_t i = 0; i < 2; ++i) EXPECT_EQ(scaled.variance()[i], std::ldexp(plain.variance()[i], 100));
    EXPECT_EQ(plain.beyondFloat() + scaled.beyondFloat(), 0u);
    EXPECT_EQ(tooBright.beyondFloat(), 2u);
    EXPECT_EQ(tooBright.image()[0], std::numeric_limits<float>::max());
    EXPECT_EQ(tooDark.beyondFloat(), 2u);
}

TEST(Film, MorePassesThanItHasRoomForAreRefused) {
    const ReconstructionFilter box(Kind::Box, {});
    Film film(window(2, 1), box);
    const std::vector<PixelSum> sums(2);
    film.addSums(sums, Film::kMostPasses - 1);
    film.endPass();
    EXPECT_EQ(film.passes(), Film::kMostPasses);
    EXPECT_THROW(film.addSums(sums, 1), Error);
    EXPECT_THROW(film.endPass(), Error);
}

TEST(FixedPointImage, ProductsAreTheSumsOfTheirPixels) {
    // Over the borders of tiles, in all ranges and across their bounds, with negative weights and zeros.
    constexpr size_t kWidth = 70, kHeight = 41;
    struct Product {
        size_t x, y;
        std::vector<float> columns, rows;
        Rgb value;
        double scale;
    };
    CounterRng rng(11);
    std::vector<Product> products(4000);
    for (Product& p : products) {
        p.x = static_cast<size_t>(rng.nextDouble() * (kWidth - 6));
        p.y = static_cast<size_t>(rng.nextDouble() * (kHeight - 6));
        for (auto* weights : {&p.columns, &p.rows}) {
            weights->resize(1 + static_cast<size_t>(rng.nextDouble() * 6));
            for (float& w : *weights) w = rng.next1D() < 0.1f ? 0.0f : rng.next1D() - 0.2f;
        }
        p.value = Rgb(rng.next1D(), 1e-3f * rng.next1D(), 0) * std::exp(50 * rng.next1D() - 25);
        p.scale = 1e-3;
    }
    FixedPointImage sums(kWidth, kHeight), together(kWidth, kHeight), expected(kWidth, kHeight);
    for (const Product& p : products) {
        EXPECT_TRUE(sums.addProduct(p.x, p.y, p.columns, p.rows, p.value, p.scale));
        for (size_t j = 0; j < p.rows.size(); ++j)
            for (size_t i = 0; i < p.columns.size(); ++i) {
                const double row = p.scale * p.rows[j];
                EXPECT_TRUE(expected.add((p.y + j) * kWidth + p.x + i, p.value, row * p.columns[i]));
            }
    }
    std::vector<std::jthread> threads;
    for (size_t t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            for (size_t i = t; i < products.size(); i += 4) {
                const Product& p = products[i];
                together.addProduct(p.x, p.y, p.columns, p.rows, p.value, p.scale);
            }
        });
    threads.clear();
    size_t lit = 0;
    for (size_t i = 0; i < kWidth * kHeight; ++i) {
        const auto sum = expected.take(i);
        ASSERT_EQ(sums.take(i), sum) << i;
        ASSERT_EQ(together.take(i), sum) << i;
        lit += sum[0] != 0;
    }
    EXPECT_GT(lit, kWidth * kHeight / 2);
}

TEST(FixedPointImage, ProductsThatAreNotFiniteOrTooLargeAreToldOf) {
    const std::array<float, 2> weights{0.5f, 0.25f};
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const Rgb& bad : {Rgb(1, nan, 1), Rgb(0, 0, inf), Rgb(-inf, 0, 0), Rgb(1e20f, 0, 0)}) {
        FixedPointImage sums(8, 8);
        EXPECT_FALSE(sums.addProduct(1, 1, weights, weights, bad, 1));
        EXPECT_TRUE(sums.addProduct(1, 1, weights, weights, Rgb(1), 1));
        EXPECT_EQ(sums.take(9)[0], 0.25);
    }
}

TEST(Film, EyeAndSplatsAddUpOverPasses) {
    Film film(window(2, 1), ReconstructionFilter(Kind::Box, {}));
    for (int pass = 0; pass < 4; ++pass) {
        film.addEye(0, Rgb(1, 2, 3));
        film.addEye(0, Rgb(1, 0, 0));
        SplatList splats;
        splats.pixels.push_back({0, Rgb(4, 0, 0)});
        splats.film.push_back({Vec2f(1.5f, 0.5f), Rgb(0, 8, 0)});
        film.addSplats(splats, 0.5, 0.25);
        film.endPass();
    }
    EXPECT_EQ(film.passes(), 4u);
    EXPECT_EQ(film.image(), (std::vector<float>{4, 2, 3, 0, 2, 0}));
}

TEST(Film, ImageBeforeTheFirstPassIsBlack) {
    const Film film(window(2, 2), ReconstructionFilter(Kind::Box, {}));
    EXPECT_EQ(film.image(), std::vector<float>(12, 0.0f));
    EXPECT_TRUE(std::isinf(film.relativeError()));
}

TEST(Film, SplatsSpreadWithTheFilterAndCropsAgreeWithTheWholeImage) {
    const ReconstructionFilter filter(Kind::Mitchell, {});
    Film whole(window(12, 10), filter), crop({12, 10, 5, 3, 4, 6}, filter);
    CounterRng rng(5);
    for (int i = 0; i < 500; ++i) {
        SplatList splats;
        // Also beside the image and far off it, where nothing may happen.
        const Vec2f u = rng.next2D();
        splats.film.push_back({Vec2f(u.x * 16 - 2, u.y * 14 - 2), Rgb(rng.next1D())});
        whole.addSplats(splats, 1);
        crop.addSplats(splats, 1);
    }
    SplatList far;
    far.film.push_back({Vec2f(1e30f, -1e30f), Rgb(1.0f)});
    whole.addSplats(far, 1);
    whole.endPass();
    crop.endPass();
    const auto wholeImage = whole.image(), cropImage = crop.image();
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 4; ++x)
            EXPECT_EQ(cropImage[static_cast<size_t>(3 * (y * 4 + x))],
                      wholeImage[static_cast<size_t>(3 * ((y + 3) * 12 + x + 5))]);

    Film one(window(9, 9), filter);
    SplatList splats;
    splats.film.push_back({Vec2f(4.2f, 3.9f), Rgb(1.0f)});
    one.addSplats(splats, 1);
    one.endPass();
    const auto image = one.image();
    for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 9; ++x)
            EXPECT_NEAR(image[static_cast<size_t>(3 * (y * 9 + x))],
                        filter.evaluate(x, 9, 4.2f) * filter.evaluate(y, 9, 3.9f), 1e-7);
}

TEST(Film, EyeSamplesAndSplatsEstimateTheSameImage) {
    // A gradient seen through the filter: eye samples on a lattice, splats on a fine grid.
    const ReconstructionFilter filter(Kind::CatmullRom, {});
    const FilmWindow full{6, 4, 2, 1, 3, 2};
    const auto radiance = [](const Vec2f& p) { return Rgb(p.x, p.y, p.x * p.y); };
    Film eye(full, filter), light(full, filter);
    const int n = 300000;
    for (uint32_t pixel = 0; pixel < 6; ++pixel)
        for (int i = 0; i < n; ++i) {
            float weight = 0;
            const double golden = i * 0.6180339887498949;
            const Vec2f u((static_cast<float>(i) + 0.5f) / n,
                          static_cast<float>(golden - std::floor(golden)));
            const Vec2f position = eye.samplePosition(pixel, u, weight);
            eye.addEye(pixel, radiance(position) * weight);
        }
    const int m = 256;  // one point in each cell of the filter's table
    for (int i = 0; i < 6 * m * 4 * m; ++i) {
        const Vec2f p((static_cast<float>(i % (6 * m)) + 0.5f) / m,
                      (static_cast<float>(i / (6 * m)) + 0.5f) / m);
        SplatList splats;
        splats.film.push_back({p, radiance(p)});
        light.addSplats(splats, 1);
    }
    eye.endPass();
    light.endPass();
    const auto a = eye.image(), b = light.image();
    for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i] / n, b[i] / (m * m), 2e-3) << i;
}

TEST(Film, ImageThatDoesNotFitTheMachineIsRefused) {
    const FilmWindow largest = window(1 << 14, 1 << 14);
    const uint64_t bytes = (uint64_t{1} << 28) * 176;
    if (physicalMemoryBytes() == 0 || physicalMemoryBytes() > bytes)
        GTEST_SKIP() << "this machine has memory for the largest image: " << sizeText(physicalMemoryBytes());
    try {
        Film film(largest, ReconstructionFilter(Kind::Box, {}));
        FAIL() << "not refused";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("film: 16384x16384 pixels would take 44.0 GiB"),
                  std::string::npos)
            << error.what();
    }
}

TEST(Film, NonFiniteAndHugeValuesAreCountedNotAdded) {
    Film film(window(2, 1), ReconstructionFilter(Kind::Box, {}));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    film.addEye(0, Rgb(1, nan, 1));
    film.addEye(0, Rgb(kInfinity, 0, 0));
    SplatList splats;
    splats.pixels.push_back({0, Rgb(nan)});
    splats.pixels.push_back({0, Rgb(-kInfinity, 0, 0)});
    splats.pixels.push_back({1, Rgb(1e30f)});
    splats.film.push_back({Vec2f(0.5f, 0.5f), Rgb(0, 0, nan)});
    splats.film.push_back({Vec2f(nan, 0.5f), Rgb(1.0f)});
    film.addSplats(splats, 1);
    const Film::LeftOut leftOut = film.endPass();
    EXPECT_EQ(film.image(), std::vector<float>(6, 0.0f));
    EXPECT_EQ(leftOut.pixels, 2u);
    EXPECT_EQ(leftOut.pixelSplats, 3u);
    EXPECT_EQ(leftOut.filmSplats, 2u);
    film.addEye(1, Rgb(3e38f));
    EXPECT_EQ(film.endPass().pixels, 1u) << "of the pass alone";
}

TEST(Film, VarianceOfTheMeanOfKnownNumbers) {
    Film film(window(1, 1), ReconstructionFilter(Kind::Box, {}));
    for (float y : {1.0f, 2.0f, 4.0f}) {
        film.addEye(0, Rgb(y));
        film.endPass();
    }
    // Sample variance of {1, 2, 4} is 7/3, of the mean 7/9.
    EXPECT_NEAR(film.variance()[0], 7.0 / 9, 1e-5);
}

TEST(Film, RefusesAWindowOutsideTheImage) {
    const ReconstructionFilter filter(Kind::Box, {});
    EXPECT_THROW(Film({4, 4, 2, 0, 3, 4}, filter), Error);
    EXPECT_THROW(Film({4, 4, 0, 0, 0, 4}, filter), Error);
    EXPECT_THROW(Film({4, 4, -1, 0, 2, 2}, filter), Error);
}

/// Passes of an AR(1) process around mean 2 with stationary deviation 1 per pixel; root-mean-square relative
/// error that the estimate gives, and that of the mean image in truth.
struct ErrorPair {
    double estimated, truth;
};
ErrorPair correlatedPasses(double rho, int passes, int side) {
    Film film(window(side, side), ReconstructionFilter(Kind::Box, {}));
    const int pixels = side * side;
    std::vector<double> state(static_cast<size_t>(pixels));
    CounterRng rng(hashKey(17, static_cast<uint64_t>(1000 * rho)));
    const auto normal = [&] {
        return std::sqrt(-2 * std::log(1 - rng.nextDouble())) *
               std::cos(2 * std::numbers::pi * rng.nextDouble());
    };
    for (double& x : state) x = normal();
    for (int pass = 0; pass < passes; ++pass) {
        for (int i = 0; i < pixels; ++i) {
            double& x = state[static_cast<size_t>(i)];
            film.addEye(static_cast<uint32_t>(i), Rgb(static_cast<float>(2 + x)));
            x = rho * x + std::sqrt(1 - rho * rho) * normal();
        }
        film.endPass();
    }
    // Variance of the mean of n values of an AR(1) process.
    const double n = passes;
    const double variance = (1 + 2 * rho / (1 - rho) * (1 - (1 - std::pow(rho, n)) / (n * (1 - rho)))) / n;
    return {film.relativeError(), std::sqrt(variance / (4 * 1.01))};
}

TEST(Film, ErrorEstimateHoldsForCorrelatedPasses) {
    // 256 pixels with 16 blocks or more each: the estimate of the variance scatters by less than 3 %.
    for (double rho : {0.0, 0.5, 0.8, 0.95}) {
        const ErrorPair error = correlatedPasses(rho, 4096, 16);
        EXPECT_NEAR(error.estimated / error.truth, 1, 0.2) << "rho " << rho;
    }
}

TEST(Film, ErrorEstimateOfIndependentPassesIsKnownEarly) {
    EXPECT_TRUE(std::isinf(correlatedPasses(0, 7, 16).estimated));
    for (int passes : {8, 15, 50}) {
        const ErrorPair error = correlatedPasses(0, passes, 64);
        EXPECT_NEAR(error.estimated / error.truth, 1, 0.2) << passes << " passes";
    }
}

TEST(Film, ErrorEstimateWatchesPartOfALargeImage) {
    const ErrorPair error = correlatedPasses(0.5, 256, 100);
    EXPECT_NEAR(error.estimated / error.truth, 1, 0.2);
}

}  // namespace
}  // namespace metrolux::core
