#pragma once
/// The lights. Radiometric quantities are linear RGB; lengths are scene units. The make functions throw Error
/// for parameters out of range.

#include "base/transform.h"
#include "endpoint/light.h"
#include "geometry/shape.h"
#include "scattering/texture.h"

#include <vector>

namespace metrolux {

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
/// convention: texel centres in u, the first and last row lie on the poles; u = 0 is local -z, u = 1/4 is
/// +x).
struct EnvironmentMapParameters {
    Transform toWorld;          ///< may rotate, mirror and scale uniformly
    int width = 0, height = 0;  ///< at least 1 x 2
    std::vector<Rgb> pixels;    ///< row by row from the zenith; finite, not negative
    float scale = 1;
};
LightPtr makeEnvironmentMap(EnvironmentMapParameters parameters);

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

}  // namespace metrolux
