/// Scenes with dispersion: a known radiance for every integrator, and a prism that all agree on. Error rates:
/// rendering.h.

#include "base/state_archive.h"
#include "rendering.h"
#include "scattering/rough_dielectric.h"

#include <tbb/task_arena.h>

#include <array>

namespace metrolux::core {
namespace {

using namespace test;

std::vector<std::string> integratorNames() {
    std::vector<std::string> names;
    for (const IntegratorDescription& integrator : integratorList()) names.push_back(integrator.name);
    return names;
}

/// From 1.4 at 750 nm to 2.1 at 380 nm: no glass is like that, and what is wrong shows.
RelativeIndex strongGlass() { return {Dispersion::cauchy(std::array{1.2, 0.13}), 1}; }

class Dispersive : public ::testing::TestWithParam<std::string> {
  protected:
    bool is(const char* name) const { return GetParam() == name; }
    bool hasChains() const {
        return is("mcmc_vcm") || is("vpt") || is("split_mcmc") || is("mmlt") || is("pssmlt") ||
               is("pssmlt_merge");
    }
};

/// All channels of the mean of the image against a known radiance.
void expectWhite(const BlockStatistics& statistics, double detectable, const std::string& what) {
    for (size_t channel = 0; channel < 3; ++channel) {
        const boost::math::students_t distribution(statistics.degreesOfFreedom());
        const double critical =
            boost::math::quantile(boost::math::complement(distribution, comparisonLevel() / 2));
        const double error = std::sqrt(statistics.varianceOfMean(channel));
        EXPECT_LE(std::abs(statistics.mean(channel) - 1), critical * error)
            << what << ": channel " << channel << " is " << statistics.mean(channel) << " +- " << error;
        EXPECT_LE(2 * critical * error, detectable) << what << ": too noisy to decide";
    }
}

TEST_P(Dispersive, AGlassBallInAWhiteSkyVanishesInAllColors) {
    if (is("light")) GTEST_SKIP() << "light tracing does not see through what is specular";
    SceneBuilder b;
    b.add(makeSphere(Transform(), {0, 0, 0}, 1, false), makeDielectric({strongGlass()}));
    b.light(makeConstantLight({}));
    b.camera({0.2f, 0.3f, 3}, {0, 0, 0}, 35, 16, 16);
    RenderSetup s;
    s.integrator = GetParam();
    s.passes = is("mmlt") ? 256 : 80;
    s.radius = 0.02;
    s.columns = s.rows = 1;
    expectWhite(renderSeeds(*b.build(), s), hasChains() ? 0.3 : 0.1, GetParam());
}

TEST_P(Dispersive, AWhiteBallInGlassVanishesInAllColors) {
    if (is("light") || is("mmlt")) GTEST_SKIP() << "as in furnace_test.cpp";
    if (is("sppm") || is("vpt"))
        GTEST_SKIP() << "hardly a photon in each of so few pixels: too noisy to decide";
    SceneBuilder b;
    b.add(makeSphere(Transform(), {0, 0, 0}, 1, false), diffuse(1));
    b.add(makeSphere(Transform(), {0, 0, 0}, 1.1f, false), makeDielectric({strongGlass()}));
    b.light(makeConstantLight({}));
    b.camera({0.2f, 0.3f, 2.5f}, {0, 0, 0}, 25, 16, 16);
    RenderSetup s;
    s.integrator = GetParam();
    s.passes = hasChains() ? 48 : 96;
    s.radius = 0.02;
    s.columns = s.rows = 1;
    expectWhite(renderSeeds(*b.build(), s), hasChains() ? 0.4 : 0.1, GetParam());
}

/// A prism and a rough ball of strong glass on paper, under a lamp that is large enough to be hit.
std::shared_ptr<Scene> glassOnPaper() {
    SceneBuilder b;
    b.add(rectangle({0, 0, 0}, {0, 1, 0}, 3, 3), diffuse(0.8f));
    RoughDielectricParameters rough;
    rough.eta = strongGlass();
    rough.alphaU = rough.alphaV = constant(Rgb(0.3f));
    b.add(makeSphere(Transform(), {0.7f, 0.55f, 0}, 0.5f, false), makeRoughDielectric(rough));
    b.add(makeSphere(Transform(), {-0.7f, 0.6f, 0}, 0.5f, false), makeDielectric({strongGlass()}));
    b.emit(b.add(rectangle({0, 3, 0.5f}, {0, -1, 0}, 0.9f, 0.9f), diffuse(0)), Rgb(6));
    b.camera({0, 1.6f, 3.2f}, {0, 0.35f, 0}, 45, 24, 24);
    b.limits().maxDepth = 8;
    return b.build();
}

TEST_P(Dispersive, AgreesWithPathTracing) {
    if (is("path")) GTEST_SKIP() << "the others are compared with it";
    // Light tracing does not see what lies behind smooth glass, photon mapping blurs it.
    if (is("light") || is("sppm") || is("vpt")) GTEST_SKIP() << "does not find all the light, or blurs it";
    const auto scene = glassOnPaper();
    RenderSetup path{"path", 64}, other{GetParam(), is("mmlt") ? 160 : hasChains() ? 64 : 32, 0.01};
    for (RenderSetup* s : {&path, &other}) s->columns = s->rows = 2;
    expectSame(renderSeeds(*scene, path), renderSeeds(*scene, other), is("mmlt") ? 0.5 : 0.25, GetParam(),
               true);
}

/// The wavelength of a pass, and of a chain, is part of what a rendering goes on with.
TEST_P(Dispersive, GivesTheSameBitsOnAnyThreadsAndAfterAResume) {
    const auto scene = glassOnPaper();
    CommonOptions options;
    options.limits = scene->parts().limits;
    options.seed = 5;
    const auto renderPasses = [&](int threads, bool resume) {
        Film film = makeFilm(*scene);
        auto integrator = makeIntegrator(GetParam(), *scene, options, {});
        tbb::task_arena(threads).execute([&] {
            for (int i = 0; i < 4; ++i) {
                integrator->renderPass(film, film.passes());
                if (!resume || i != 1) continue;
                StateWriter writer;
                integrator->saveState(writer);
                integrator = makeIntegrator(GetParam(), *scene, options, {});
                const std::string state = writer.take();
                StateReader reader(state);
                integrator->loadState(reader);
            }
        });
        return film.image();
    };
    const std::vector<float> one = renderPasses(1, false);
    EXPECT_EQ(one, renderPasses(2, false));
    EXPECT_EQ(one, renderPasses(2, true));
}

INSTANTIATE_TEST_SUITE_P(All, Dispersive, ::testing::ValuesIn(integratorNames()),
                         [](const auto& i) { return i.param; });

/// What --error waits for: colors that have not converged are noise.
TEST(DispersiveError, SeesTheColorsOfThePasses) {
    const auto error = [](const RelativeIndex& eta, double& brightness) {
        SceneBuilder b;
        b.add(makeSphere(Transform(), {0, 0, 0}, 1, false), makeDielectric({eta}));
        b.light(makeConstantLight({}));
        b.camera({0, 0, 3}, {0, 0, 0}, 25, 16, 16);  // the ball fills the image
        const auto scene = b.build();
        CommonOptions options;
        options.limits = scene->parts().limits;
        Film film = makeFilm(*scene);
        const auto integrator = makeIntegrator("path", *scene, options, {});
        for (int i = 0; i < 64; ++i) integrator->renderPass(film, film.passes());
        brightness = 0;
        const std::vector<float> image = film.image();
        for (size_t i = 0; i < image.size(); i += 3)
            brightness +=
                double(luminance({image[i], image[i + 1], image[i + 2]})) * 3 / double(image.size());
        return film.relativeError();
    };
    double plain = 0, dispersed = 0;
    EXPECT_LT(error(1.5f, plain), 1e-3) << "without dispersion all paths are worth 1";
    // The luminance of a pass's color has a standard deviation of 0.76.
    const double estimate = error(strongGlass(), dispersed);
    EXPECT_NEAR(estimate, 0.76 / 8, 0.02);
    EXPECT_NEAR(plain, 1, 1e-3);
    EXPECT_LT(std::abs(dispersed - 1), estimate) << "evenly spread wavelengths do better than the estimate";
}

}  // namespace
}  // namespace metrolux::core
