#include "io/mitsuba/context.h"

#include "io/mitsuba/parser.h"

namespace metrolux::core::mitsuba {

std::filesystem::path LoadContext::resolve(const Element& element, const std::string& filename) {
    try {
        return *files.insert(findFile(filename, element.location.file, searchPaths)).first;
    } catch (const Error& problem) {
        throw element.error(problem.what());
    }
}

}  // namespace metrolux::core::mitsuba
