#include "app/commands.h"
#include "app/option_parsing.h"
#include "integrators/scene_choice.h"
#include "io/scene_loader.h"

#include <fmt/format.h>

#include <cctype>
#include <cxxabi.h>
#include <map>
#include <memory>
#include <set>
#include <typeinfo>

namespace metrolux::core::app {
namespace {

constexpr const char* kInfoExamples = R"(Examples:
  metrolux info scene.xml
  metrolux info scene.xml --lenient        # what would be left out is listed as warnings)";

struct InfoArguments {
    std::string scene;
    std::vector<std::string> defines;
    bool lenient = false;
};

/// Class name without namespaces, for people.
template <class Object>
std::string kindOf(const Object& object) {
    int status = 0;
    const std::unique_ptr<char, decltype(&std::free)> name(
        abi::__cxa_demangle(typeid(object).name(), nullptr, nullptr, &status), &std::free);
    const std::string full = status == 0 ? name.get() : typeid(object).name();
    const size_t colon = full.rfind("::");
    return colon == std::string::npos ? full : full.substr(colon + 2);
}

std::string countsText(const std::map<std::string, size_t>& counts) {
    std::string text;
    for (const auto& [kind, count] : counts)
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, kind);
    return text.empty() ? "none" : text;
}

struct Census {
    std::map<std::string, size_t> shapes, bsdfs, lights;
    size_t primitives = 0;
    std::set<const Bsdf*> seen;

    void add(const Shape& shape, size_t times) {
        ++shapes[kindOf(shape)];
        primitives += shape.primitiveCount() * times;
        if (shape.bsdf && seen.insert(shape.bsdf.get()).second) ++bsdfs[kindOf(*shape.bsdf)];
    }
};

Census census(const SceneParts& parts) {
    Census result;
    for (const ShapePtr& shape : parts.shapes) result.add(*shape, 1);
    std::map<const ShapeGroup*, size_t> uses;
    for (const Instance& instance : parts.instances) ++uses[instance.group.get()];
    for (const auto& [group, count] : uses)
        for (const ShapePtr& shape : group->shapes) result.add(*shape, count);
    for (const LightPtr& light : parts.lights) ++result.lights[kindOf(*light)];
    return result;
}

int info(const InfoArguments& a) {
    LoadOptions options;
    options.defines = parseDefines(a.defines);
    options.lenient = a.lenient;
    SceneParts read = loadScene(a.scene, options);
    settleSceneIntegrator(read, a.lenient);
    const Scene scene(std::move(read));
    const SceneParts& parts = scene.parts();
    const Census counts = census(parts);
    const FilmWindow& w = scene.camera().window();
    const ReconstructionFilter filter(parts.filterKind, parts.filter);

    fmt::print("scene       {}\n", parts.source);
    fmt::print("film        {}x{} pixels", w.fullWidth, w.fullHeight);
    if (w.width != w.fullWidth || w.height != w.fullHeight)
        fmt::print(", crop {}x{} at {},{}", w.width, w.height, w.x, w.y);
    fmt::print(", filter {} of radius {}\n", filterName(parts.filterKind), filter.radius());
    const Vec3f eye = scene.camera().position();
    fmt::print("sensor      {} at ({:.4g}, {:.4g}, {:.4g})\n", kindOf(scene.camera()), eye.x, eye.y, eye.z);
    const IntegratorDescription* const integrator = integratorOf(parts.integrator);
    fmt::print("integrator  {} ({}), ", parts.integrator.type,
               integrator ? "rendered by " + integrator->name : std::string("not supported"));
    if (parts.limits.maxDepth < 0)
        fmt::print("paths of any length");
    else
        fmt::print("paths of at most {} edges", parts.limits.maxDepth);
    fmt::print(", roulette after {}{}\n", parts.limits.rouletteDepth,
               parts.limits.hideEmitters ? ", lights are not shown" : "");
    fmt::print("shapes      {}\n", countsText(counts.shapes));
    fmt::print("primitives  {}\n", counts.primitives);
    if (!parts.instances.empty()) fmt::print("instances   {}\n", parts.instances.size());
    fmt::print("bsdfs       {}\n", countsText(counts.bsdfs));
    fmt::print("lights      {}\n", countsText(counts.lights));
    const SceneBounds& b = scene.bounds();
    fmt::print("bounds      sphere of radius {:.4g} around ({:.4g}, {:.4g}, {:.4g})\n", b.radius, b.center.x,
               b.center.y, b.center.z);
    for (const std::string& warning : parts.warnings) fmt::print("warning     {}\n", warning);
    return kDone;
}

}  // namespace

Run addInfoCommand(CLI::App& parent) {
    CLI::App* app = parent.add_subcommand("info", "Show what was understood of a scene");
    app->footer(kInfoExamples);
    auto a = std::make_shared<InfoArguments>();
    app->add_option("scene", a->scene, "Mitsuba scene (XML)")->required();
    app->add_option("-D,--define", a->defines, "Value for a <default> or $parameter of the scene")
        ->option_text("NAME=VALUE")
        ->allow_extra_args(false);
    app->add_flag("--lenient", a->lenient,
                  "Warn of unknown plugins and parameters instead of refusing the scene");
    return [a] { return info(*a); };
}

}  // namespace metrolux::core::app
