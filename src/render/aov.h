#pragma once
#include "image/film.h"
#include "image/image_io.h"
#include "scene/scene.h"

#include <string>
#include <vector>

namespace metrolux::core {

/// What can be written beside the image, as layers of an EXR.
enum class Aov {
    Albedo,    ///< R, G, B: Bsdf::albedo of the first surface
    Normal,    ///< X, Y, Z: its shading normal in world space, not turned toward the camera
    Depth,     ///< Z: distance along the camera ray in scene units, mean over the rays that hit something
    Variance,  ///< Y: variance of the mean of the luminance (Film::variance)
    Denoised,  ///< R, G, B: the image without its noise (render/denoiser.h)
    Alpha,     ///< A of the image itself: share of the rays that hit something; colors are not divided by it
    // Of the first surface on the ray through the middle of pixel and lens, since means of these mean
    // nothing:
    Position,       ///< X, Y, Z: in the coordinates of the scene's file
    Uv,             ///< U, V
    Object,         ///< X: number of the object, from 1 (attribute metrolux:objects); 0 where there is none
    Material,       ///< X: number of the material, the same way (metrolux:materials)
    Motion,         ///< X, Y: 0, as nothing moves
    ObjectMattes,   ///< cryptomatte of the objects (render/mattes.h)
    MaterialMattes  ///< cryptomatte of the materials
};

/// The name of Aov::Denoised. Files of a single picture show it where it is there.
inline constexpr const char* kDenoisedLayer = "denoised";

/// Throws Error for a name that none has.
Aov aovFromName(const std::string& name);
/// "albedo, normal, ...", for messages and descriptions.
std::string aovNames();
/// Whether the layer is a picture that people look at.
bool isShown(Aov aov);

struct CameraLayers {
    std::vector<ImageLayer> layers;
    Metadata attributes;  ///< that say what is in the layers
};
/// Those of the wanted ones that surfaces have which the camera sees first, without light. Means are those of
/// kAovSamples jittered rays in the square of each pixel of the camera's window (no reconstruction filter).
/// Where nothing is hit, layers are zero.
CameraLayers renderAovs(const Scene& scene, const std::vector<Aov>& wanted);
inline constexpr int kAovSamples = 16;

/// The layer of Film::variance().
ImageLayer varianceLayer(const Film& film);

}  // namespace metrolux::core
