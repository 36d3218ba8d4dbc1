#pragma once
#include "scattering/texture.h"
#include "scattering/textures/uv_transform.h"

namespace metrolux::core {

/// Mitsuba 0.6's `gridtexture`: lines along the borders of the unit squares of uv, color1, with color0
/// between them.
struct LinesParameters {
    TexturePtr color0, color1;
    float lineWidth = 0.01f;  ///< from a border to the edge of its line: the line is twice as wide
    UvTransform toUv;
};
TexturePtr makeLines(const LinesParameters& parameters);

}  // namespace metrolux::core
