#include "integrators/own_image.h"

#include "base/state_archive.h"
#include "integrators/registry.h"
#include "support/glass_scene.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

TEST(OwnImage, HasThePassesOfOneIntegratorAlone) {
    const FilmWindow window{4, 3, 0, 0, 4, 3};
    Film film(window, ReconstructionFilter(ReconstructionFilter::Kind::Box, {}));
    OwnImage image(window);
    SplatList splats;
    splats.pixels.push_back({5, Rgb(2.0f)});
    for (int pass = 0; pass < 3; ++pass) {
        film.addEye(5, Rgb(1.0f));
        film.addSplats(splats, 0.25);
        image.addPass(film);
        film.endPass();
        film.addEye(5, Rgb(100.0f));  // another's
        film.endPass();
    }
    EXPECT_EQ(image.passes(), 3u);
    EXPECT_NEAR(image.last()[5], 1.5, 1e-12);
    EXPECT_NEAR(image.sums()[5], 4.5, 1e-12);
    EXPECT_EQ(image.sums()[4], 0);
}

/// What the default decides does not depend on the slices that share its film. On any number of ranks each
/// slice has the same bits.
TEST(OwnImage, TheStateOfTheDefaultDoesNotKnowOfOtherSlices) {
    const std::shared_ptr<Scene> scene = test::glassScene();
    for (const char* target : {"luminance", "relative"}) {
        std::string states[2];
        for (const bool shared : {false, true}) {
            CommonOptions options;
            options.limits = scene->parts().limits;
            const auto integrator =
                makeIntegrator("mcmc_vcm", *scene, options, {{"target", std::string(target)}});
            Film film = test::gaussianFilm(*scene);
            for (uint32_t pass = 0; pass < 20; ++pass) {
                integrator->renderPass(film, pass);
                if (!shared) continue;
                for (int i = 0; i < film.pixelCount(); ++i)
                    film.addEye(uint32_t(i), Rgb(0.01f * float(i % 7)));
                film.endPass();
            }
            StateWriter writer;
            integrator->saveState(writer);
            states[shared] = writer.take();
        }
        EXPECT_TRUE(states[0] == states[1]) << target;
    }
}

}  // namespace
}  // namespace metrolux::core
