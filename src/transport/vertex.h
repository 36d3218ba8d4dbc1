#pragma once
#include "geometry/shape.h"
#include "scattering/bsdf.h"
#include "spatial/point_span.h"
#include "transport/mis.h"

#include <cstring>
#include <optional>
#include <type_traits>

namespace metrolux::core {

/// A vertex of a subpath, on a surface or in a medium: a plain value that can be connected and merged without
/// its subpath.
struct Vertex {
    SurfaceInteraction si;
    Vec3f toPrevious{0.0f};  ///< unit direction to the predecessor
    float distanceToPrevious = 0;
    Rgb throughput{0.0f};    ///< product of value / density up to the arrival at this vertex
    MediumIndex medium = 0;  ///< through which the subpath has come
    bool inMedium = false;   ///< it is a point of `medium`, not of a surface
    bool dispersed = false;  ///< it or a vertex before lies on a surface with dispersion
    MisState mis;            ///< at arrival
    uint32_t pixel = 0;      ///< eye subpaths: index in the rendered window
    int depth = 0;           ///< edges between the endpoint and this vertex

    // What a vertex scatters and emits by. Here alone it is known to be a BSDF, which in a medium is that of
    // media/medium_point.h.

    /// Whether other subpaths can be joined with it; false if it only has delta lobes.
    bool hasSmoothLobe() const { return bsdf().hasSmoothLobe(); }
    /// Whether merging finds too few photons for the lobe (Bsdf::isNarrow).
    bool isNarrow() const { return bsdf().isNarrow(si); }
    Rgb albedo() const { return bsdf().albedo(si); }
    /// Whether it matters which wavelength the subpath has.
    bool isDispersive() const { return si.wavelength > 0 && bsdf().isDispersive(); }
    /// Null unless it lies on an area light.
    const Light* emitter() const { return si.shape->emitter.get(); }
    /// Factor of a direction in all densities per area and geometric factors: |cos| with the geometric
    /// normal, in a medium (densities per volume) 1.
    float cosine(const Vec3f& w) const { return inMedium ? 1.0f : absDot(w, si.ng); }
    /// Bsdf::stopDensity() for a direction in world space. Lamps are vertices whatever their BSDF lets pass.
    Rgb stopDensity(const Vec3f& w) const {
        return si.shape->emitter ? Rgb(1.0f) : bsdf().stopDensity(si, si.toLocal(w));
    }
    /// Directions in the frame of the shading normal: `known` to the predecessor, the result away from it.
    std::optional<BsdfSample> sample(const Vec3f& known, TransportMode mode, float uLobe,
                                     const Vec2f& u) const {
        return bsdf().sample(si, known, mode, uLobe, u);
    }
    /// S and densities for world directions.
    BsdfEvaluation evaluate(const Vec3f& toEye, const Vec3f& toLight) const {
        return bsdf().evaluate(si, si.toLocal(toEye), si.toLocal(toLight));
    }

  private:
    const Bsdf& bsdf() const { return *si.shape->bsdf; }
};

/// Where they lie, for a VertexGrid.
inline PointSpan positionsOf(std::span<const Vertex> vertices) {
    return {vertices, [](const Vertex& v) -> const Vec3f& { return v.si.p; }};
}

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
    const BsdfEvaluation e = v.evaluate(v.toPrevious, toLight);
    return {e.value, e.pdfLight, e.pdfEye};
}

/// Light vertex toward the eye side. Value: S |wEye.Ng| / |wLight.Ng|, Veach's adjoint (5.3.4): the only
/// place, with lightSampleFactor, where the asymmetry of shading normals enters.
inline VertexScattering scatterLight(const Vertex& v, const Vec3f& toEye) {
    const float cosineLight = v.cosine(v.toPrevious);
    if (!(cosineLight > 0)) return {};
    const BsdfEvaluation e = v.evaluate(toEye, v.toPrevious);
    return {e.value * (v.cosine(toEye) / cosineLight), e.pdfEye, e.pdfLight};
}

/// The same factor for a sampled direction of a light subpath, whose weight is S / pdf.
inline float lightSampleFactor(const Vertex& v, const Vec3f& sampled) {
    const float cosineLight = v.cosine(v.toPrevious);
    return cosineLight > 0 ? v.cosine(sampled) / cosineLight : 0.0f;
}

}  // namespace metrolux::core
