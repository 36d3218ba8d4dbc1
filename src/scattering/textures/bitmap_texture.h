#pragma once
#include "scattering/texture.h"
#include "scattering/textures/uv_transform.h"

#include <vector>

namespace metrolux::core {

/// An image as a texture. Orientation as in Mitsuba 3: after `toUv`, (0, 0) is the corner of the first pixel
/// of the first row, v grows from row to row. (Meshes whose files count v upward, OBJ among them, flip it
/// when they are loaded.)
struct BitmapTextureParameters {
    enum class Filter { Bilinear, Nearest };
    enum class Wrap { Repeat, Mirror, Clamp, Zero, One };  ///< the last two: a constant outside of the image

    int width = 0, height = 0;
    int channels = 3;                                  ///< 1 or 3
    std::shared_ptr<const std::vector<float>> pixels;  ///< linear, row by row, channels interleaved
    Filter filter = Filter::Bilinear;
    Wrap wrapU = Wrap::Repeat, wrapV = Wrap::Repeat;
    UvTransform toUv;
};

/// Throws Error when the sizes and the data do not fit together.
TexturePtr makeBitmapTexture(const BitmapTextureParameters& parameters);

}  // namespace metrolux::core
