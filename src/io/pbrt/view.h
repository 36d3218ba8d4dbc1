#pragma once
#include "io/pbrt/parameters.h"

namespace metrolux::core::pbrt {

/// A directive with a type: Camera "perspective" ...
struct TypedDirective {
    std::string type;
    Parameters parameters;
    bool isGiven = false;
};

/// What stands before WorldBegin: how the scene is looked at.
struct View {
    TypedDirective camera, film, filter, integrator;
    Transform cameraToWorld;

    /// The sensor with its film and filter.
    mitsuba::ElementPtr sensor(Reading& reading) const;
    mitsuba::ElementPtr integratorElement(Reading& reading) const;
    /// What the film's sensor multiplies light by: exposure time times ISO / 100.
    double exposure() const;
};

}  // namespace metrolux::core::pbrt
