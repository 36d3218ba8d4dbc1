#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace metrolux::core::soak {

/// A Mitsuba scene and the files that it names. Most are plain; some have what breaks renderers: coincident
/// surfaces, needles, triangles of no area, extreme scales, a camera or a light inside glass, no light at
/// all.
struct RandomScene {
    std::string xml;
    std::vector<std::pair<std::string, std::string>> files;  ///< name, content
};

/// The same seed gives the same scene, with one compiler.
RandomScene makeRandomScene(uint64_t seed);

}  // namespace metrolux::core::soak
