#pragma once
/// Taking the noise out of what a session has rendered: by Open Image Denoise where it is installed, and by a
/// filter of our own elsewhere.

#include "image/half_sums.h"
#include "image/image_io.h"
#include "render/features.h"

#include <string>
#include <vector>

namespace metrolux::core {

/// What a checkpoint keeps for the filter. Parts of a rendering are merged without its scene, so that the
/// features are in it too.
struct DenoisingState {
    HalfSums halves;
    DenoisingFeatures features;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(halves, features);
    }
    /// From the bytes of a checkpoint, of a film of so many pixels. Throws Error.
    static DenoisingState parse(const std::string& bytes, size_t pixels);
};

struct DenoisedImage {
    ImageLayer layer;                   ///< kDenoisedLayer
    std::string denoiser;               ///< "Open Image Denoise 2.3.0", "own filter"
    std::vector<std::string> warnings;  ///< why it is not what was asked for
};
/// Needs the scene no more. `halves` is closed.
DenoisedImage denoise(const Film& film, const HalfSums& halves, const DenoisingFeatures& features);

/// Throws Error when a library was named for denoising that cannot be used, so that a rendering need not end
/// to find out.
void checkDenoiser();

}  // namespace metrolux::core
