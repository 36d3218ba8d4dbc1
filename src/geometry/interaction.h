#pragma once
#include "base/frame.h"
#include "base/math.h"

namespace metrolux::core {

class Shape;
class Transform;

/// A point on a surface. Trivially copyable: it is stored with every path vertex.
struct SurfaceInteraction {
    Vec3f p{0.0f};   ///< position, world space
    Vec3f ng{0.0f};  ///< unit geometric normal, pointing to the outside of the shape (never flipped toward
                     ///< the viewer)
    Vec3f ns{0.0f};  ///< unit shading normal, on the same side as ng by construction of the mesh normals
    Vec3f s{0.0f};   ///< unit shading tangent, along dp/du made orthogonal to ns
    Vec2f uv{0.0f};  ///< texture coordinates
    const Shape* shape = nullptr;  ///< gives the BSDF and the emitter; for instances the prototype shape
    const Transform* placement = nullptr;  ///< of the instance, null outside of instances
    uint32_t primitive = 0;                ///< triangle index within the shape, 0 for analytic shapes
    Vec2f barycentric{0.0f};               ///< weights of the triangle's second and third vertex
    /// Nanometers, of the light that indices of refraction are asked for; 0: the d line. What fills an
    /// interaction in leaves it alone: a subpath has one wavelength.
    float wavelength = 0;

    Frame frame() const { return {s, cross(ns, s), ns}; }
    Vec3f toLocal(const Vec3f& v) const { return {dot(v, s), dot(v, cross(ns, s)), dot(v, ns)}; }
    Vec3f toWorld(const Vec3f& v) const { return s * v.x + cross(ns, s) * v.y + ns * v.z; }
};

}  // namespace metrolux::core
