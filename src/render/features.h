#pragma once
/// What denoising knows of the surfaces that a picture shows.

#include "image/image_io.h"
#include "scene/scene.h"

#include <vector>

namespace metrolux::core {

/// Of each pixel of a film, seen through its reconstruction filter, so that features and colors have the same
/// edges. Through smooth glass and mirrors they are those of what is seen there.
struct DenoisingFeatures {
    std::vector<float> albedo;  ///< 3 a pixel: Bsdf::albedo of the first rough surface, with the tint of what
                                ///< is before it
    std::vector<float> normal;  ///< 3 a pixel: its shading normal in world space
    std::vector<float>
        inverseDistance;  ///< 1 a pixel: 1 / distance of the first surface along the camera ray, which is
                          ///< linear in the picture of a plane; 0 where nothing is
    bool empty() const { return albedo.empty(); }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(albedo, normal, inverseDistance);
    }
};

/// From kFeatureSamples camera rays a pixel.
DenoisingFeatures renderFeatures(const Scene& scene);
inline constexpr int kFeatureSamples = 16;

}  // namespace metrolux::core
