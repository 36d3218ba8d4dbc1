#pragma once
/// Moves the camera of a scene as a hand does: around a point, toward it, and beside it.

#include "view/board.h"

#include <metrolux/scene.h>

namespace metrolux::core::view {

/// The sensor's to_world.
metrolux::Transform cameraOf(const metrolux::Scene& scene);

class CameraHandle {
  public:
    /// Up is the axis of the world to which the camera's up is nearest.
    explicit CameraHandle(const metrolux::Scene& scene);
    /// Where the camera of this scene would be.
    metrolux::Transform moved(const metrolux::Scene& scene, const CameraMotion& motion);

  private:
    void findPivot(const metrolux::Scene& scene);
    Vector up_;
    std::optional<Vector> pivot_;  ///< in the coordinates of the file
    double pixelAtPivot_ = 0;      ///< width of a pixel there
};

}  // namespace metrolux::core::view
