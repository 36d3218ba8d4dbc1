#include "integrators/integrator.h"

namespace metrolux::core {

void Integrator::renderPass(Film& film, uint32_t pass) {
    addPass(film, pass);
    const Film::LeftOut leftOut = film.endPass();
    // Values too large for the film are counted as those of the technique that most of them come from.
    nonFinite_.add(Technique::Hit, leftOut.pixels);
    nonFinite_.add(Technique::Merge, leftOut.pixelSplats);
    nonFinite_.add(Technique::Splat, leftOut.filmSplats);
}

Wavelength wavelengthOf(const Scene& scene, uint64_t seed, uint32_t pass) {
    return scene.hasDispersion() ? Wavelength::ofPass(seed, pass) : Wavelength{};
}

Film makeFilm(const Scene& scene) {
    return {scene.camera().window(), ReconstructionFilter(scene.parts().filterKind, scene.parts().filter),
            scene.emissionExponent()};
}

}  // namespace metrolux::core
