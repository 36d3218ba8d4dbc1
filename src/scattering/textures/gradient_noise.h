#pragma once
/// Noise in space [Perlin 2002, Improving Noise], and its sums over octaves as pbrt has them. All in [-1, 1],
/// but for sums of octaves whose weights do not fall.

#include "base/math.h"

namespace metrolux::core {

/// Zero at all points of whole numbers.
float gradientNoise(const Vec3f& p);

/// Frequencies grow by 1.99 from octave to octave, weights by `roughness`. pbrt leaves out octaves that
/// pixels do not resolve; here all are there, and passes average them.
float fractalNoise(const Vec3f& p, float roughness, int octaves);
/// The same of absolute values.
float turbulence(const Vec3f& p, float roughness, int octaves);

}  // namespace metrolux::core
