#pragma once

namespace metrolux::core {

/// The part of the image that is rendered, in pixels of the full image.
struct FilmWindow {
    int fullWidth = 768, fullHeight = 576;
    int x = 0, y = 0, width = 768, height = 576;
    int pixelCount() const { return width * height; }
};

}  // namespace metrolux::core
