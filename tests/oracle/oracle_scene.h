#pragma once
/// Small scenes in which all techniques meet: lights of every kind, alone and together, five cameras,
/// materials with and without delta lobes.

#include "scene/scene.h"

#include <memory>

namespace metrolux::core::test {

inline constexpr float kGlassEta = 1.5f;
/// At which the glass of Materials::Dispersive has that index, in nanometers; at the d line it has 1.38.
inline constexpr float kGlassWavelength = 450;
inline constexpr int kImageWidth = 32, kImageHeight = 24;

enum class Lighting {
    Area,
    SphereArea,
    TexturedArea,
    Point,
    Spot,
    Projector,
    Collimated,
    Goniometric,
    Directional,
    Constant,
    EnvironmentMap,
    SunSky,
    Many,               ///< with a place: all are in the light tree
    ManyAndEnvironment  ///< a light tree, a directional light and an environment
};
enum class Lens { Pinhole, Thin, Orthographic, Panorama, Fisheye };
enum class Materials {
    Plain,      ///< each either delta or not
    Mixed,      ///< smooth coats, blends and masks: delta and other lobes at one point
    Shading,    ///< shading normals other than the geometric ones
    Layered,    ///< coatings, mixtures, rough diffuse, a diffuse transmitter
    Media,      ///< in colored fog, with a ball of denser one, a veil, and glass that absorbs
    Dispersive  ///< glass whose index depends on the wavelength
};

/// The camera, described once more: its densities are computed here from its parameters.
struct OracleLens {
    Lens kind = Lens::Pinhole;
    Vec3f origin{0.0f}, x{0.0f}, y{0.0f}, axis{0.0f};
    double near = 0.01;    ///< rays begin at this distance along the axis
    double radius = 0;     ///< of the lens
    double imageArea = 1;  ///< of the image on the plane at distance 1; orthographic: in the world;
                           ///< others: of longitude and latitude, of
                           ///< the angle from the axis around it

    /// A point of the lens; all of an orthographic camera's rays are parallel to `axis` instead.
    Vec3f point(const Vec2f& uLens) const;
    /// Per solid angle, of the direction `w` into the scene, over the whole image.
    double pdfDirection(const Vec3f& w) const {
        const double cosine = double(dot(w, axis)), across = double(dot(w, x)), up = double(dot(w, y));
        if (kind == Lens::Panorama) return 1 / (imageArea * std::hypot(across, cosine));
        if (kind == Lens::Fisheye) {
            const double sine = std::hypot(across, up);
            return std::atan2(sine, cosine) / (imageArea * sine);
        }
        return 1 / (imageArea * cosine * cosine * cosine);
    }
    /// Per area perpendicular to the axis.
    double pdfPosition() const { return 1 / imageArea; }
};

/// What is on the way between two points of the scene with Materials::Media, computed from the spheres that
/// bound its media and the rectangle of its veil.
struct OracleMedia {
    static constexpr float kVeilOpacity = 0.6f;
    bool present = false;
    /// Of a walk, for each channel.
    Rgb survival(const Vec3f& a, const Vec3f& b) const;
    Rgb extinction(const Vec3f& p) const;
    /// Whether the segment runs nearly along a boundary: rounding changes how much of it is inside.
    bool isGrazing(const Vec3f& a, const Vec3f& b) const;
};

struct OracleScene {
    std::shared_ptr<Scene> scene;
    OracleLens lens;
    OracleMedia media;
    BsdfPtr veil;  ///< the one that lets light pass straight on; others refract
};

OracleScene makeOracleScene(Lighting lighting, Lens lens, Materials materials);

}  // namespace metrolux::core::test
