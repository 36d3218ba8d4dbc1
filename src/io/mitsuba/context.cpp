#include "io/mitsuba/context.h"

#include "io/mitsuba/parser.h"

namespace metrolux::mitsuba {

std::filesystem::path LoadContext::resolve(const Element& element, const std::string& filename) const {
    try {
        return findFile(filename, element.location.file, searchPaths);
    } catch (const Error& problem) {
        throw element.error(problem.what());
    }
}

}  // namespace metrolux::mitsuba
