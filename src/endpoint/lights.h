#pragma once
/// The lights. Radiometric quantities are linear RGB; lengths are scene units. The make functions throw Error
/// for parameters out of range.

#include "base/transform.h"
#include "endpoint/light.h"
#include "geometry/shape.h"
#include "scattering/texture.h"

#include <vector>

namespace metrolux::core {

/// A shape that emits the same radiance in all directions of its front side (where its geometric normal
/// points). Keeps a plain pointer to the shape, which owns its light.
struct AreaLightParameters {
    const Shape* shape = nullptr;
    TexturePtr radiance;
};
LightPtr makeAreaLight(const AreaLightParameters& parameters);

/// Equal radiant intensity in all directions.
struct PointLightParameters {
    Vec3f position{0.0f};
    Rgb intensity{1.0f};  ///< flux per steradian
};
LightPtr makePointLight(const PointLightParameters& parameters);

/// A cone of light along local +z. The intensity falls linearly with the angle from the beam's edge to the
/// cutoff.
struct SpotLightParameters {
    Transform toWorld;
    Rgb intensity{1.0f};     ///< flux per steradian within the beam
    float cutoffAngle = 20;  ///< degrees from the axis, in (0, 180]
    float beamWidth = 15;    ///< degrees from the axis, in [0, cutoffAngle]
    TexturePtr
        texture;  ///< projected along the axis, multiplies the intensity; may be null (cutoff < 90 if not)
};
LightPtr makeSpotLight(const SpotLightParameters& parameters);

/// Parallel light from infinitely far away.
struct DirectionalLightParameters {
    Vec3f direction{0, 0, 1};  ///< in which the light travels
    Rgb irradiance{1.0f};      ///< on a surface perpendicular to the direction
};
LightPtr makeDirectionalLight(const DirectionalLightParameters& parameters);

/// Environment of equal radiance.
struct ConstantLightParameters {
    Rgb radiance{1.0f};
};
LightPtr makeConstantLight(const ConstantLightParameters& parameters);

/// Environment from a latitude-longitude image, +y up in local space; interpolated bilinearly (Mitsuba 3's
/// convention: texel centers in u, the first and last row lie on the poles; u = 0 is local -z, u = 1/4 is
/// +x).
struct EnvironmentMapParameters {
    Transform toWorld;          ///< may rotate, mirror and scale uniformly
    int width = 0, height = 0;  ///< at least 1 x 2
    std::vector<Rgb> pixels;    ///< row by row from the zenith; finite, not negative
    float scale = 1;
};
LightPtr makeEnvironmentMap(EnvironmentMapParameters parameters);

/// Environment of a clear sky (Hosek & Wilkie 2012) above a black ground, and a sun's disc before it. Either
/// may be left out: the sky by its scale, the sun by an empty profile. The sky is symmetric about the plane
/// of zenith and sun, so that these two directions place it.
struct SunSkyParameters {
    Vec3f up{0, 0, 1};            ///< the zenith
    Vec3f sunDirection{0, 0, 1};  ///< toward the sun, not below the horizon
    float turbidity = 3;          ///< in [1, 10]
    Rgb albedo{0.3f};             ///< of the ground, each channel in [0, 1]
    float skyScale = 1;           ///< multiplies radiance in W / (m^2 sr nm), see HosekSky::radiance
    /// Stretches angles from the zenith, in [1, 2]: the horizon moves to 90 degrees times this, and sky and
    /// sun move along.
    float stretch = 1;
    float sunAperture = 0.5358f;  ///< the disc's angular diameter in degrees, in (0, 90)
    /// Radiance of the disc at equal steps of area from its center to its limb, linear between; one value is
    /// a uniform disc.
    std::vector<Rgb> sunProfile;
};
LightPtr makeSunSky(const SunSkyParameters& parameters);

/// The reverse of a perspective camera: projects a texture along local +z. The irradiance on the plane z = 1
/// is pi * scale * texture (so in Mitsuba 3).
struct ProjectorParameters {
    Transform toWorld;
    TexturePtr irradiance;
    float scale = 1;
    float tanHalfFovX = 0.5f;  ///< half the width of the projected image on the plane z = 1
    float aspect = 1;          ///< width / height of the projected image
};
LightPtr makeProjector(const ProjectorParameters& parameters);

/// An infinitely thin beam along local +z.
struct CollimatedLightParameters {
    Transform toWorld;
    Rgb power{1.0f};
};
LightPtr makeCollimatedLight(const CollimatedLightParameters& parameters);

}  // namespace metrolux::core
