#pragma once
#include "scattering/texture.h"

#include <string>

namespace metrolux::core {

/// The interpolated attribute `name` ("vertex_..." or "face_...") of the shape that is hit, times `scale`.
/// Black on a shape without it.
struct MeshAttributeParameters {
    std::string name;
    float scale = 1;
};
TexturePtr makeMeshAttribute(const MeshAttributeParameters& parameters);

}  // namespace metrolux::core
