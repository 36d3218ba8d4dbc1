#include "app/commands.h"
#include "app/option_parsing.h"
#include "base/error.h"
#include "io/mitsuba/xml_writer.h"
#include "io/scene_loader.h"

#include <fmt/format.h>

#include <memory>

namespace metrolux::core::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kConvertExamples = R"(Examples:
  metrolux convert scene.glb scene.xml     # meshes and images go to scene_files/
  metrolux convert scene.pbrt scene.xml
  metrolux convert scene.xml fixed.xml -D material=glass

The new scene renders to the same bits.)";

struct ConvertArguments {
    std::string from, to;
    std::vector<std::string> defines;
    bool overwrite = false;
};

int convert(const ConvertArguments& a) {
    const fs::path to = a.to;
    if (to.extension() != ".xml") throw Error("{}: expected a name that ends with .xml", a.to);
    if (fs::exists(to) && !a.overwrite)
        throw Error("{}: exists and is not replaced without --overwrite", a.to);
    if (fs::exists(to) && fs::exists(a.from) && fs::equivalent(to, a.from))
        throw Error("{}: is the scene that is read", a.to);
    LoadOptions options;
    options.defines = parseDefines(a.defines);
    options.fragment = true;
    const mitsuba::ParsedScene scene = parseSceneFile(a.from, options);
    for (const std::string& warning : scene.warnings) fmt::print(stderr, "[warning] {}\n", warning);
    for (const fs::path& file : mitsuba::writeScene(scene, to)) fmt::print("wrote {}\n", file.string());
    return kDone;
}

}  // namespace

Run addConvertCommand(CLI::App& parent) {
    CLI::App* app = parent.add_subcommand("convert", "Write a scene as Mitsuba 3's XML");
    app->footer(kConvertExamples);
    auto a = std::make_shared<ConvertArguments>();
    app->add_option("scene", a->from, "Mitsuba scene (XML) of version 2.x or 3.x, glTF, or pbrt")->required();
    app->add_option("output", a->to, "File to write, NAME.xml")->required();
    app->add_option("-D,--define", a->defines, "Value for a <default> or $parameter of the scene")
        ->option_text("NAME=VALUE")
        ->allow_extra_args(false);
    app->add_flag("--overwrite", a->overwrite, "Replace a file that exists");
    return [a] { return convert(*a); };
}

}  // namespace metrolux::core::app
