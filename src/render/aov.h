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
    Alpha      ///< A of the image itself: share of the rays that hit something; colors are not divided by it
};

/// The name of Aov::Denoised. Files of a single picture show it where it is there.
inline constexpr const char* kDenoisedLayer = "denoised";

/// "albedo", "normal", "depth", "variance", "denoised", "alpha". Throws Error for another name.
Aov aovFromName(const std::string& name);

/// Layers for albedo, normal, depth and alpha of those that are wanted, from kAovSamples jittered rays in the
/// square of each pixel of the camera's window (no reconstruction filter). Where nothing is hit, they are
/// zero.
std::vector<ImageLayer> renderAovs(const Scene& scene, const std::vector<Aov>& wanted);
inline constexpr int kAovSamples = 16;

/// The layer of Film::variance().
ImageLayer varianceLayer(const Film& film);

}  // namespace metrolux::core
