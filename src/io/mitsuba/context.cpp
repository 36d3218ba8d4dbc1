#include "io/mitsuba/context.h"

#include "io/mitsuba/parser.h"
#include "io/mitsuba/world_origin.h"

namespace metrolux::core::mitsuba {

std::filesystem::path LoadContext::resolve(const Element& element, const std::string& filename) {
    try {
        return *files.insert(findFile(filename, element.location.file, searchPaths)).first;
    } catch (const Error& problem) {
        throw element.error(problem.what());
    }
}

ImageData LoadContext::image(const Element& element, bool raw) {
    const PixelArray* data = element.pixels("data");
    if (!data) {
        const std::filesystem::path file = resolve(element, element.requiredString("filename"));
        try {
            return readImage(file, raw, &memory);
        } catch (const Error& problem) {
            throw element.error(problem.what());
        }
    }
    if (element.has("filename")) throw element.error("found both \"data\" and \"filename\", expected one");
    const auto size = static_cast<uint64_t>(std::max(data->width, 0)) *
                      static_cast<uint64_t>(std::max(data->height, 0)) *
                      static_cast<uint64_t>(std::max(data->channels, 0));
    if (size == 0 || data->channels > 4 || data->pixels.size() != size)
        throw element.error(
            fmt::format("\"data\": found {} numbers for {}x{} pixels of {} channels, expected as many as "
                        "these need, of 1 "
                        "to 4 channels",
                        data->pixels.size(), data->width, data->height, data->channels));
    memory.take(size * sizeof(float), "the image");
    return {data->width, data->height, data->channels, {data->pixels.begin(), data->pixels.end()}};
}

Transform LoadContext::toWorld(const Element& element, bool mayFlatten) const {
    return movedBy(-origin, element.transform("to_world", mayFlatten));
}

Vec3f LoadContext::place(const Element& element, const Vec3d& position) const {
    requirePlaceable(element, position, position);
    return Vec3f(position - origin);
}

}  // namespace metrolux::core::mitsuba
