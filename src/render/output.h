#pragma once
#include "image/image_io.h"

#include <filesystem>
#include <string>
#include <vector>

namespace metrolux::core {

/// An image with what belongs to it.
struct RenderedFrame {
    ImageData image;
    std::vector<ImageLayer> layers;
    Metadata metadata;
};

/// The image files of a session: EXR with everything, PNG for looking at.
class OutputSet {
  public:
    struct Display {
        float exposure = 0;  ///< stops, PNG only
        ToneCurve curve = ToneCurve::Srgb;
    };
    /// Throws Error when a file is not .exr or .png, is named twice, or could not be written.
    OutputSet(std::vector<std::filesystem::path> files, const Display& display);

    /// Writes all files; returns a message for each that could not be written, the others are there.
    std::vector<std::string> write(const RenderedFrame& frame) const;

    struct RescueResult {
        std::vector<std::string> failures;           ///< as of write()
        std::vector<std::filesystem::path> rescued;  ///< written in place of the failed ones
    };
    /// As write(), and tries `metrolux-rescue-NAME` in the working directory, then in the system's folder for
    /// temporary files, for each file that could not be written.
    RescueResult writeOrRescue(const RenderedFrame& frame) const;

    const std::vector<std::filesystem::path>& files() const { return files_; }

  private:
    void writeOne(const std::filesystem::path& file, const RenderedFrame& frame) const;
    std::vector<std::filesystem::path> files_;
    Display display_;
};

}  // namespace metrolux::core
