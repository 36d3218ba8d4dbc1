/// A module includes only modules above it (docs/explain/architecture.md, "Modules, in dependency order"):
/// reads every #include of src/.

#include "paths.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

/// What each module may include besides itself. It is narrower than the order: transport and markov do not
/// know each other, io makes scenes and does not render.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"base", {}},
    {"sampling", {"base"}},
    {"spatial", {"base"}},
    {"image", {"base"}},
    {"geometry", {"base"}},
    {"scattering", {"base", "geometry", "image"}},
    {"media", {"base", "geometry", "scattering"}},
    {"endpoint", {"base", "image", "geometry", "scattering"}},
    {"scene", {"base", "image", "geometry", "scattering", "media", "endpoint"}},
    {"transport",
     {"base", "spatial", "sampling", "image", "geometry", "scattering", "endpoint", "media", "scene"}},
    {"wavefront",
     {"base", "spatial", "sampling", "image", "geometry", "scattering", "endpoint", "media", "scene",
      "transport"}},
    {"markov", {"base", "sampling"}},
    {"integrators",
     {"base", "spatial", "sampling", "image", "geometry", "scattering", "endpoint", "media", "scene",
      "transport", "wavefront", "markov"}},
    {"io", {"base", "image", "geometry", "scattering", "endpoint", "media", "scene"}},
    {"render",
     {"base", "sampling", "image", "geometry", "scattering", "endpoint", "media", "scene", "integrators",
      "io"}},
    {"mpi", {"render"}},
    {"vdb", {"io"}},
    {"study",
     {"base", "spatial", "image", "geometry", "endpoint", "media", "scene", "transport", "wavefront",
      "integrators", "render"}},
    {"api", {"base", "image", "geometry", "endpoint", "media", "scene", "integrators", "io", "render"}},
    {"view",
     {"base", "image", "geometry", "endpoint", "media", "scene", "integrators", "io", "render", "api"}},
    {"app",
     {"base", "sampling", "image", "geometry", "scattering", "endpoint", "media", "scene", "integrators",
      "io", "render", "study", "api", "view"}},
};

struct Include {
    std::string file, path;
    int line;
};

std::vector<Include> includesOf(const fs::path& root) {
    static const std::regex pattern(R"(^\s*#\s*include\s*"([^"]+)\")");
    std::vector<Include> result;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
        if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") continue;
        std::ifstream in(entry.path());
        std::string text;
        for (int line = 1; std::getline(in, text); ++line) {
            std::smatch match;
            if (std::regex_search(text, match, pattern))
                result.push_back({fs::relative(entry.path(), root).generic_string(), match[1], line});
        }
    }
    return result;
}

std::string moduleOf(const std::string& path) { return path.substr(0, path.find('/')); }

const fs::path kSource = fs::path(METROLUX_SOURCE_DIR) / "src";

TEST(ModuleOrder, EveryFileBelongsToAModule) {
    for (const fs::directory_entry& entry : fs::directory_iterator(kSource)) {
        if (!entry.is_directory()) continue;
        EXPECT_TRUE(kMayInclude.contains(entry.path().filename().string())) << entry.path();
    }
}

TEST(ModuleOrder, IncludesPointUpwards) {
    const std::vector<Include> includes = includesOf(kSource);
    ASSERT_GT(includes.size(), 100u) << "the sources were not found";
    for (const Include& i : includes) {
        const std::string from = moduleOf(i.file), to = moduleOf(i.path);
        EXPECT_TRUE(fs::exists(kSource / i.path))
            << i.file << ":" << i.line << " includes \"" << i.path << "\": own headers are named from src/";
        if (from == to) continue;
        const auto allowed = kMayInclude.find(from);
        ASSERT_NE(allowed, kMayInclude.end()) << i.file;
        EXPECT_TRUE(allowed->second.contains(to)) << i.file << ":" << i.line << " includes \"" << i.path
                                                  << "\": " << from << " may not depend on " << to;
    }
}

TEST(ModuleOrder, TheOrderItselfHasNoCycle) {
    const std::vector<std::string> order = {
        "base",     "sampling", "spatial",   "image",     "geometry", "scattering",  "media",
        "endpoint", "scene",    "transport", "wavefront", "markov",   "integrators", "io",
        "render",   "mpi",      "vdb",       "study",     "api",      "view",        "app"};
    std::set<std::string> above;
    for (const std::string& module : order) {
        for (const std::string& included : kMayInclude.at(module))
            EXPECT_TRUE(above.contains(included)) << module;
        above.insert(module);
    }
    EXPECT_EQ(above.size(), kMayInclude.size());
}

TEST(ModuleOrder, HeadersMayBeIncludedTwice) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kSource)) {
        if (entry.path().extension() != ".h") continue;
        std::ifstream in(entry.path());
        const std::string text((std::istreambuf_iterator<char>(in)), {});
        EXPECT_NE(text.find("#pragma once"), std::string::npos) << entry.path();
    }
}

}  // namespace
}  // namespace metrolux::core
