#include "app/all_sensors.h"

#include "app/commands.h"
#include "base/error.h"

#include <algorithm>

namespace metrolux::core::app {
namespace {

namespace fs = std::filesystem;

/// Of an id what file names may hold.
std::string fileNamePart(std::string sensor) {
    for (char& c : sensor)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_' && c != '.') c = '_';
    return sensor;
}

std::string named(const std::string& file, const std::string& part) {
    const fs::path path(file);
    fs::path result = path;
    result.replace_extension("." + part + path.extension().string());
    return result.string();
}

}  // namespace

bool wantsAllSensors(const RenderArguments& a) { return a.sensor == "all"; }

int renderAllSensors(const RenderArguments& a) {
    if (!a.files.checkpoint.empty() || a.slices > 0)
        throw Error("--sensor all: checkpoints and slices are of one rendering, name one sensor");
    if (a.live.isWanted()) throw Error("--sensor all: --serve and --tev show one rendering, name one sensor");
    metrolux::LoadOptions options = loadOptions(a);
    options.sensor.clear();
    const std::vector<std::string> sensors = sensorNames(a.scene, api::coreOptions(options));
    if (sensors.empty()) throw Error("{}: found no <sensor>, expected one at least", a.scene);
    std::vector<std::string> parts;
    for (size_t i = 0; i < sensors.size(); ++i) {
        std::string part = fileNamePart(sensors[i]);
        if (std::find(parts.begin(), parts.end(), part) != parts.end()) part += "." + std::to_string(i);
        parts.push_back(std::move(part));
    }
    for (size_t i = 0; i < sensors.size(); ++i) {
        RenderArguments one = a;
        one.sensor = std::to_string(i);
        if (one.outputs.empty()) one.outputs.push_back(sceneName(a.scene) + ".exr");
        for (std::string& output : one.outputs) output = named(output, parts[i]);
        if (!one.stats.empty()) one.stats = named(one.stats, parts[i]);
        if (const int status = render(one, std::nullopt); status != kDone) return status;
    }
    return kDone;
}

}  // namespace metrolux::core::app
