#pragma once
#include "base/error.h"
#include "base/frame.h"
#include "base/transform.h"

namespace metrolux::core {

/// Throws Error when a light's color is negative or not finite.
inline void requireEmission(const Rgb& value, const char* light) {
    if (!isFinite(value) || value.x < 0 || value.y < 0 || value.z < 0)
        throw Error("{} light: the emission ({}, {}, {}) must be finite and not negative", light, value.x,
                    value.y, value.z);
}

/// The axes of local space, made unit length: a light's transform may rotate, mirror and scale uniformly.
inline Frame localAxes(const Transform& toWorld) {
    return {normalize(toWorld.vector({1, 0, 0})), normalize(toWorld.vector({0, 1, 0})),
            normalize(toWorld.vector({0, 0, 1}))};
}

}  // namespace metrolux::core
