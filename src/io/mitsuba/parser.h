#pragma once
/// Mitsuba XML (2.x and 3.x, and 0.x upgraded) to a tree of Elements: includes, defaults, references and
/// units of the file format are resolved; plugins are not known here.

#include "base/memory_budget.h"
#include "io/mitsuba/properties.h"

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace metrolux::core::mitsuba {

struct ParsedScene {
    ElementPtr root;                      ///< <scene>; its objects are children, in order of appearance
    std::set<const Element*> referenced;  ///< elements that some <ref> uses
    std::vector<std::filesystem::path>
        searchPaths;              ///< in order: <path>s, the last first; then the scene's folder
    std::set<std::string> files;  ///< the scene, its includes and spectra, as locations name them
    std::vector<std::string> warnings;
};

/// Throws Error. When lenient, a missing or unknown version and <subsurface> are warnings. The
/// elements are booked on `memory`, if given.
ParsedScene parseScene(const std::filesystem::path& file, const std::map<std::string, std::string>& defines,
                       bool lenient = false, MemoryBudget* memory = nullptr);

/// The existing regular file that `filename`, written in the file `from`, names. Included files look in their
/// own folder first, then all in `searchPaths`; the working folder comes last. Throws Error that lists the
/// folders, and for a pointer of Git LFS in place of the file.
std::filesystem::path findFile(const std::string& filename, const std::filesystem::path& from,
                               const std::vector<std::filesystem::path>& searchPaths);

}  // namespace metrolux::core::mitsuba
