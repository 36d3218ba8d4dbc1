#include "integrators/integrator.h"

namespace metrolux::core {

Film makeFilm(const Scene& scene) {
    return {scene.camera().window(), ReconstructionFilter(scene.parts().filterKind, scene.parts().filter)};
}

}  // namespace metrolux::core
