#pragma once
#include "io/pbrt/textures.h"

namespace metrolux::core::pbrt {

/// A shape without its material.
struct ShapePart {
    mitsuba::Maker made;
    double area = 0;       ///< in the world
    double triangles = 1;  ///< pbrt makes a light of each
};

/// What is asked of a shape besides its surface.
struct ShapeOptions {
    bool reversed = false;  ///< ReverseOrientation holds
    bool withBack =
        false;  ///< it emits to both sides: a second surface right behind it, turned around, is made
    bool isTextured = false;  ///< its uv have to be pbrt's, which differ from ours on spheres and disks
    bool needsArea = false;   ///< ShapePart::area and triangles of a mesh in a file too
};

/// What a Shape directive says.
std::vector<ShapePart> makeShape(const std::string& type, const Parameters& parameters,
                                 const Transform& toWorld, const ShapeOptions& options, Reading& reading);

/// Types that are read, for messages and documents.
std::vector<std::string> shapeTypes();

}  // namespace metrolux::core::pbrt
