#pragma once
#include "io/mitsuba/parser.h"

namespace metrolux::core::mitsuba {

/// A scene as Mitsuba 3's XML, which renders to the same bits. Meshes, images and volumes that are in no file
/// of their own go to PLY, EXR and VOL files in a folder beside it, `NAME_files`; other files stay where they
/// are. Returns all files that it writes, the scene's last. Throws Error for a scene of 0.x, whose plugins
/// and rules are not those of 3, before anything is written.
std::vector<std::filesystem::path> writeScene(const ParsedScene& scene, const std::filesystem::path& file);

}  // namespace metrolux::core::mitsuba
