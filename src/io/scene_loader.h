#pragma once
#include "scene/scene.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace metrolux::core {

struct LoadOptions {
    std::map<std::string, std::string> defines;  ///< -D name=value: override <default>s
    bool lenient = false;                        ///< unknown plugins and properties warn instead of failing
    bool strict = false;                         ///< any warning is an Error
    bool fragment = false;      ///< a scene without a sensor is let pass: SceneParts::camera is null then
    std::string sensor;         ///< number (from 0) or id of the sensor; empty: the first
    int width = 0, height = 0;  ///< --resolution; 0: the film's
    uint64_t memoryBytes = 0;   ///< most that the scene's data may take; 0: what the machine has
    bool hasCrop = false;
    int cropX = 0, cropY = 0, cropWidth = 0, cropHeight = 0;  ///< --crop, pixels of the full image
};

/// Reads a Mitsuba XML scene. Throws Error. `files`, if given, receives the names of all files that were
/// read, the scene's first.
SceneParts loadScene(const std::filesystem::path& file, const LoadOptions& options,
                     std::vector<std::filesystem::path>* files = nullptr);

}  // namespace metrolux::core
