#pragma once
/// A diffuse floor, a ball of glass and an area light, for tests of the passes; in fog, whose boundary light
/// passes, if that is wanted; the glass may have dispersion.

#include "image/film.h"
#include "scattering/null_bsdf.h"
#include "support/small_scenes.h"

namespace metrolux::core::test {

inline std::shared_ptr<Scene> glassScene(bool fog = false, const DielectricParameters& glass = {}) {
    SceneBuilder b;
    if (fog) {
        b.media() = {
            makeHomogeneousMedium(Rgb(0.2f, 0.1f, 0.3f), Rgb(0.9f), makeHenyeyGreensteinPhase(0.5f))};
        b.add(makeSphere(Transform(), {0, 1, 0}, 7, false), makeNullBsdf())->media = MediumSides{1, 0};
    }
    b.add(rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), diffuse(0.7f));
    b.add(makeSphere(Transform(), {0, 1, 0}, 0.7f, false), makeDielectric(glass));
    b.emit(b.add(rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), diffuse(0.3f)), Rgb(5));
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 48, 40);
    b.limits().maxDepth = 6;
    return b.build();
}

inline Film gaussianFilm(const Scene& scene) {
    return {scene.camera().window(), ReconstructionFilter(ReconstructionFilter::Kind::Gaussian, {})};
}

}  // namespace metrolux::core::test
