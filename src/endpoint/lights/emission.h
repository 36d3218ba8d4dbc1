#pragma once
#include "base/error.h"
#include "base/frame.h"
#include "base/transform.h"
#include "endpoint/endpoint.h"

#include <optional>

namespace metrolux::core {

/// Throws Error when a light's color is negative or not finite.
inline void requireEmission(const Rgb& value, const char* light) {
    if (!isFinite(value) || value.x < 0 || value.y < 0 || value.z < 0)
        throw Error("{} light: the emission ({}, {}, {}) must be finite and not negative", light, value.x,
                    value.y, value.z);
}

/// How a point x sees a light that is at one place: where and how far it is. Nothing at the place itself.
inline std::optional<EndpointConnection> connectionToPoint(const Vec3f& position, const Vec3f& x) {
    EndpointConnection c;
    c.point = position;
    c.distance = (position - x).length();
    if (!(c.distance > 0)) return std::nullopt;
    c.wi = normalize(position - x);
    return c;
}

/// The axes of local space, made unit length: a light's transform may rotate, mirror and scale uniformly.
inline Frame localAxes(const Transform& toWorld) {
    return {normalize(toWorld.vector({1, 0, 0})), normalize(toWorld.vector({0, 1, 0})),
            normalize(toWorld.vector({0, 0, 1}))};
}

}  // namespace metrolux::core
