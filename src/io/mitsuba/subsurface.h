#pragma once
/// Mitsuba 0.6's approximation of subsurface scattering, as what it approximates.

#include "geometry/medium_sides.h"
#include "io/mitsuba/context.h"

#include <optional>

namespace metrolux::core::mitsuba {

/// What a shape with a `dipole` in it is made of.
struct SubsurfaceParts {
    MediumSides media;
    BsdfPtr boundary;  ///< dielectric, as rough as the shape's own BSDF
};
/// Nothing for a shape without one, or where it is leniently left out. `bsdf`: the shape's own, may be null.
/// Throws Error for another type, and beside a medium.
std::optional<SubsurfaceParts> subsurfaceOf(const Element& shape, const ElementPtr& bsdf,
                                            LoadContext& context);

}  // namespace metrolux::core::mitsuba
