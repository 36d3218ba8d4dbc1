#pragma once
#include "scattering/bsdf.h"

namespace metrolux::core {

/// What `bsdf` does with the light that its null lobe does not let pass: the caller decides by nullLobe()
/// whether it passes, and stopDensity() says with which probability it does not. `bsdf` itself if it has no
/// such lobe, or nothing else, or is such a model already.
BsdfPtr withoutNull(const BsdfPtr& bsdf);

}  // namespace metrolux::core
