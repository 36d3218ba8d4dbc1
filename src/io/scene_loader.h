#pragma once
#include "io/mitsuba/parser.h"
#include "scene/scene.h"

#include <filesystem>
#include <map>
#include <string>
#include <unordered_map>
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
    std::string filter;  ///< --filter: in place of the film's, of its default width; empty: the film's

    /// Throw Error for sizes that no image has.
    void setResolution(int newWidth, int newHeight);
    void setCrop(int x, int y, int newWidth, int newHeight);
};

/// What a view of the scene is made from.
struct SensorSource {
    mitsuba::ElementPtr element;
    std::vector<std::filesystem::path> searchPaths;
    bool lenient = false;
    Vec3d origin{0.0};                                               ///< SceneParts::origin
    std::unordered_map<const mitsuba::Element*, MediumIndex> media;  ///< of the scene, by element
};

/// What `strict` does with the warnings so far: throws the first as an Error.
void refuseWarnings(const SceneParts& parts);

/// Reads a Mitsuba XML scene, glTF 2.0, or a pbrt scene. Throws Error. `files`, if given, receives the names
/// of all files that were read, the scene's first. `sensor`, if given, the one that the camera was made from;
/// `tree` the scene as it was parsed.
SceneParts loadScene(const std::filesystem::path& file, const LoadOptions& options,
                     std::vector<std::filesystem::path>* files = nullptr, SensorSource* sensor = nullptr,
                     mitsuba::ParsedScene* tree = nullptr);
/// The same of a scene that is parsed already; `files` are those besides it.
SceneParts buildScene(mitsuba::ParsedScene parsed, const LoadOptions& options,
                      std::vector<std::filesystem::path>* files = nullptr, SensorSource* sensor = nullptr);

/// What `sensor` of LoadOptions may be for each of the sensors in a file: its id, or its number. Throws
/// Error.
std::vector<std::string> sensorNames(const std::filesystem::path& file, const LoadOptions& options);

/// A file as objects, before anything is built of them: Mitsuba XML, or glTF 2.0. Throws Error.
mitsuba::ParsedScene parseSceneFile(const std::filesystem::path& file, const LoadOptions& options);

/// The camera and the film of `source`, as loadScene() with these options makes them; the limits are the
/// caller's. Throws Error.
SceneView makeView(const SensorSource& source, const LoadOptions& options,
                   std::vector<std::string>& warnings);

}  // namespace metrolux::core
