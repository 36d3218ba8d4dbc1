#pragma once
#include "geometry/shape.h"
#include "scattering/bsdf.h"
#include "transport/mis.h"

#include <cstring>
#include <type_traits>

namespace metrolux::core {

/// A surface vertex of a subpath: a plain value that can be connected and merged without its subpath.
struct Vertex {
    SurfaceInteraction si;
    Vec3f toPrevious{0.0f};  ///< unit direction to the predecessor
    float distanceToPrevious = 0;
    Rgb throughput{0.0f};  ///< product of value / density up to the arrival at this vertex
    float mergeShare = 1;  ///< Strategies::mergeShare() here
    MisState mis;          ///< at arrival
    uint32_t pixel = 0;    ///< eye subpaths: index in the rendered window
    int depth = 0;         ///< edges between the endpoint and this vertex

    const Bsdf& bsdf() const { return *si.shape->bsdf; }
};

/// Makes a copy in memory that need not be initialized. Byte by byte, as wide as the processor can: Imath's
/// vectors have copy constructors of their own, which go number by number.
inline void copyVertex(const Vertex& from, Vertex* to) {
    static_assert(std::is_trivially_destructible_v<Vertex>);
    std::memcpy(static_cast<void*>(to), static_cast<const void*>(&from), sizeof(Vertex));
}

// One or several for each pixel are kept in an iteration.
static_assert(sizeof(Vertex) <= 160);

/// Value and densities of scattering at a vertex toward a world direction.
struct VertexScattering {
    Rgb value{0.0f};
    float pdfForward = 0;  ///< density of the new direction, given the predecessor; per solid angle
    float pdfReverse = 0;  ///< density of the predecessor's direction, given the new one
};

/// Eye vertex toward the light side. Value: S, as in scattering/bsdf.h.
inline VertexScattering scatterEye(const Vertex& v, const Vec3f& toLight) {
    const BsdfEvaluation e = v.bsdf().evaluate(v.si, v.si.toLocal(v.toPrevious), v.si.toLocal(toLight));
    return {e.value, e.pdfLight, e.pdfEye};
}

/// Light vertex toward the eye side. Value: S |wEye.Ng| / |wLight.Ng|, Veach's adjoint (5.3.4): the only
/// place, with lightSampleFactor, where the asymmetry of shading normals enters.
inline VertexScattering scatterLight(const Vertex& v, const Vec3f& toEye) {
    const float cosineLight = absDot(v.toPrevious, v.si.ng);
    if (!(cosineLight > 0)) return {};
    const BsdfEvaluation e = v.bsdf().evaluate(v.si, v.si.toLocal(toEye), v.si.toLocal(v.toPrevious));
    return {e.value * (absDot(toEye, v.si.ng) / cosineLight), e.pdfEye, e.pdfLight};
}

/// The same factor for a sampled direction of a light subpath, whose weight is S / pdf.
inline float lightSampleFactor(const Vertex& v, const Vec3f& sampled) {
    const float cosineLight = absDot(v.toPrevious, v.si.ng);
    return cosineLight > 0 ? absDot(sampled, v.si.ng) / cosineLight : 0.0f;
}

}  // namespace metrolux::core
