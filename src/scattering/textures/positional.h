#pragma once
/// A texture that depends on where a point lies, and not on the uv of its surface alone.

#include "base/transform.h"
#include "scattering/texture.h"

namespace metrolux::core {

class PositionalTexture : public Texture {
  public:
    /// By differences along the surface's partial derivatives.
    Vec2f gradient(const SurfaceInteraction& si) const final;
    Rgb mean() const override;
};

/// uv by the position of a point, as in pbrt: `toTexture` takes it from world space.
enum class UvMapping {
    Spherical,    ///< the angle from z over pi, that around it from x toward y over 2 pi
    Cylindrical,  ///< the angle around z from -x over 2 pi, z
    Planar        ///< x and y
};
struct MappedTextureParameters {
    TexturePtr texture;
    UvMapping mapping = UvMapping::Planar;
    Transform toTexture;
};
TexturePtr makeMappedTexture(const MappedTextureParameters& parameters);

/// Noise in space. A value is looked up between colors, of which the first is for `low` and the last for
/// `high`, in equal steps.
struct NoiseTextureParameters {
    enum class Kind {
        Fractal,     ///< sum of octaves
        Turbulence,  ///< of absolute values
        Windy,       ///< waves where wind is: |three octaves, ten times as wide| times six octaves
        Marble       ///< 1/2 + 1/2 sin(scale y + variation times the octaves at scale p)
    };
    Kind kind = Kind::Fractal;
    Transform toTexture;
    int octaves = 8;
    float roughness = 0.5f, scale = 1, variation = 0.2f;
    std::vector<Rgb> colors;
    float low = 0, high = 1;
};
/// Throws Error unless there are two colors at least, 1 to 32 octaves, and low < high.
TexturePtr makeNoiseTexture(const NoiseTextureParameters& parameters);

/// One of two textures in each place: cubes of side 1 in turn, or discs of radius 0.35 in some of the unit
/// squares of uv, moved at random (pbrt's dots).
struct CellsParameters {
    enum class Kind { Cubes, Discs };
    Kind kind = Kind::Cubes;
    TexturePtr first, second;  ///< the cubes of even sums of coordinates, the discs; the others
    Transform toTexture;       ///< of Cubes, from world space; of Discs from (u, v, 0)
};
TexturePtr makeCells(const CellsParameters& parameters);

/// The product or the sum of two textures.
struct CombinationParameters {
    enum class Kind { Product, Sum };
    Kind kind = Kind::Product;
    TexturePtr first, second;
};
TexturePtr makeCombination(const CombinationParameters& parameters);

}  // namespace metrolux::core
