#pragma once
/// pbrt scenes of a few lines: a camera close to the middle of what a test adds.

#include "cases_support.h"
#include "image/image_io.h"

namespace metrolux::core::test {

/// The quad [-1, 1]^2 at z = 0, toward +z; the upper edge of an image at y = 1.
inline const std::string kQuad = R"(Shape "trianglemesh" "point3 P" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]
  "integer indices" [0 1 2 0 2 3] "point2 uv" [0 0 1 0 1 1 0 1]
)";

/// From z = 3 (or another eye) a spot around the origin is seen.
inline std::string pbrtScene(const std::string& world, const std::string& before = "",
                             const std::string& eye = "0 0 3") {
    return "LookAt " + eye + "  0 0 0  0 1 0\n" + before + R"(Camera "perspective" "float fov" 0.2
Film "rgb" "integer xresolution" 16 "integer yresolution" 12
Integrator "path" "integer maxdepth" 8
WorldBegin
)" + world;
}

inline SceneParts loadedPbrt(const std::string& text, const LoadOptions& options = {}) {
    const TemporaryFolder folder;
    return loadScene(folder.write("scene.pbrt", text), options);
}

/// Mean radiance of what the camera sees.
inline Rgb seenPbrt(const std::string& text, int passes = 100) {
    const TemporaryFolder folder;
    const RenderableScene scene(folder.write("scene.pbrt", text), {});
    return meanOf(scene.render("path", passes, 1));
}

/// The same with "image.png" beside the scene.
inline Rgb seenWithImage(const ImageData& image, const std::string& text, int passes = 400) {
    const TemporaryFolder folder;
    folder.write("image.png", encodePngRaw(image));
    const RenderableScene scene(folder.write("scene.pbrt", text), {});
    return meanOf(scene.render("path", passes, 1));
}

}  // namespace metrolux::core::test
