#include "api/object_tree.h"

#include "api/converter.h"

namespace metrolux::core::api {

mitsuba::ParsedScene parsedScene(const Object& scene, const std::filesystem::path& folder) {
    const std::string file = (folder / "scene").string();
    if (scene.type() != "scene")
        throw Error("{}: found an object of type \"{}\", expected \"scene\"", file, scene.type());
    Converter converter(file);
    mitsuba::ParsedScene result;
    result.root = converter.convert(scene, "scene", "");
    converter.references().resolve();
    result.referenced = converter.references().referenced();
    result.searchPaths = {folder};
    return result;
}

std::shared_ptr<mitsuba::Element> parsedSensor(const Object& sensor) {
    Converter converter("sensor");
    auto element = converter.convert(sensor, "sensor", "");
    converter.references().resolve();
    return element;
}

}  // namespace metrolux::core::api
