#pragma once
#include "image/film_window.h"
#include "image/image_io.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace metrolux::core {

/// An image with what belongs to it.
struct RenderedFrame {
    ImageData image;
    std::vector<ImageLayer> layers;
    Metadata metadata;
    std::vector<std::string> warnings = {};  ///< of what is not as it was asked for
};

/// The place of a window; none for the whole image.
ImagePlace placeOf(const FilmWindow& window);

/// A file that is to be written, with the words of the user that name it ("output 'a.exr'").
struct NamedOutput {
    std::string what;
    std::filesystem::path file;
};

/// Throws Error when two outputs are one file, or an output is one of the files that the rendering reads: no
/// output costs an input. Sees through relative names, symbolic and hard links.
void checkDistinct(std::span<const NamedOutput> outputs, std::span<const std::filesystem::path> inputs);

/// The image files of a session: EXR with everything, PNG for looking at. A PNG shows the layer
/// kDenoisedLayer where there is one.
class OutputSet {
  public:
    struct Display {
        float exposure = 0;  ///< stops, PNG only
        ToneCurve curve = ToneCurve::Srgb;
    };
    /// Throws Error when a file is not .exr or .png, is named twice, or could not be written; and when it
    /// exists and was not written by Metrolux, unless `overwrite`. Its own pictures are replaced, so that
    /// a batch can run again; another program's take work to get back.
    OutputSet(std::vector<std::filesystem::path> files, const Display& display, bool overwrite = false);

    /// Writes all files; returns a message for each that could not be written, the others are there.
    std::vector<std::string> write(const RenderedFrame& frame) const;

    struct RescueResult {
        std::vector<std::string> failures;           ///< as of write()
        std::vector<std::filesystem::path> rescued;  ///< written in place of the failed ones
    };
    /// As write(), and tries `metrolux-rescue-NAME` in the working directory, then in the system's folder for
    /// temporary files, for each file that could not be written. A rescued image gets a name of its own
    /// (`metrolux-rescue-NAME`, `metrolux-rescue-1-NAME` ...) and replaces nothing.
    RescueResult writeOrRescue(const RenderedFrame& frame) const;

    /// Whether the file is for looking at: a PNG.
    static bool isPicture(const std::filesystem::path& file);
    const std::vector<std::filesystem::path>& files() const { return files_; }

  private:
    /// The bytes of the file.
    std::string encoded(const std::filesystem::path& file, const RenderedFrame& frame) const;
    std::vector<std::filesystem::path> files_;
    Display display_;
};

}  // namespace metrolux::core
