#pragma once
#include "io/pbrt/textures.h"

namespace metrolux::core::pbrt {

/// LightSource of a type, in world space. `exposure` multiplies all light: what the film's sensor makes of
/// it. Null where it is left out.
mitsuba::ElementPtr makeLight(const std::string& type, const Parameters& parameters, const Transform& toWorld,
                              const ColorSpace& space, double exposure, Reading& reading);

/// AreaLightSource "diffuse".
struct AreaLight {
    Texture radiance{Rgb(1.0f)};
    bool bothSides = false;
    double power = -1;  ///< of each triangle or quadric, if above zero; else the radiance is as it is
    Location where;

    /// For a shape of so much area and so many triangles.
    mitsuba::ElementPtr emitter(double area, double triangles, MemoryBudget& memory) const;
};
AreaLight readAreaLight(const std::string& type, const Parameters& parameters, const ColorSpace& space,
                        double exposure, Textures& textures, Reading& reading);

/// Types that are read, for messages and documents.
std::vector<std::string> lightTypes();

}  // namespace metrolux::core::pbrt
