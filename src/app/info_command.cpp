#include "api/internals.h"
#include "app/commands.h"
#include "app/image_info.h"
#include "app/option_parsing.h"
#include "app/render_options.h"
#include "integrators/scene_choice.h"
#include "io/scene_loader.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

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
  metrolux info scene.xml --lenient        # what would be left out is listed as warnings
  metrolux info scene.xml --json           # the same for programs
  metrolux info image.exr                  # its windows, channels and metadata)";

struct InfoArguments {
    std::string scene, sensor;
    std::vector<std::string> defines;
    bool lenient = false, strict = false, json = false;
};

/// Class name without namespaces, for people.
template <class Object>
std::string kindOf(const Object& object) {
    int status = 0;
    const std::unique_ptr<char, decltype(&std::free)> name(
        abi::__cxa_demangle(typeid(object).name(), nullptr, nullptr, &status), &std::free);
    const std::string full = status == 0 ? name.get() : typeid(object).name();
    const size_t colon = full.rfind("::");
    std::string own = colon == std::string::npos ? full : full.substr(colon + 2);
    if (own.ends_with('>')) own.pop_back();  // the model of a template (CosineSampled)
    return own;
}

std::string countsText(const std::map<std::string, size_t>& counts) {
    std::string text;
    for (const auto& [kind, count] : counts)
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, kind);
    return text.empty() ? "none" : text;
}

struct Census {
    std::map<std::string, size_t> shapes, bsdfs, lights, media;
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
    for (const MediumPtr& medium : parts.media) ++result.media[kindOf(*medium)];
    return result;
}

/// In the coordinates of the file.
Vec3d placeOf(const Vec3f& p, const SceneParts& parts) { return Vec3d(p) + parts.origin; }

/// Digits below the extent of the scene, wherever it is.
std::string placeText(const Vec3f& p, const SceneParts& parts) {
    const Vec3d place = placeOf(p, parts);
    const bool isFar = parts.origin != Vec3d(0.0);
    const auto text = [&](double x) { return isFar ? fmt::format("{:.10g}", x) : fmt::format("{:.4g}", x); };
    return fmt::format("({}, {}, {})", text(place.x), text(place.y), text(place.z));
}

void printCamera(const SceneParts& parts) {
    const FilmWindow& w = parts.camera->window();
    const ReconstructionFilter filter(parts.filterKind, parts.filter);
    fmt::print("film        {}x{} pixels", w.fullWidth, w.fullHeight);
    if (w.width != w.fullWidth || w.height != w.fullHeight)
        fmt::print(", crop {}x{} at {},{}", w.width, w.height, w.x, w.y);
    fmt::print(", filter {} of radius {}\n", filterName(parts.filterKind), filter.radius());
    fmt::print("sensor      {} at {}\n", kindOf(*parts.camera), placeText(parts.camera->position(), parts));
}

void print(const SceneParts& parts, const Census& counts, const SceneBounds* bounds) {
    fmt::print("scene       {}\n", printable(parts.source));
    if (parts.camera)
        printCamera(parts);
    else
        fmt::print("sensor      none\n");
    const IntegratorDescription* const integrator = integratorOf(parts.integrator);
    fmt::print("integrator  {} ({}), ", printable(parts.integrator.type),
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
    if (!counts.media.empty()) fmt::print("media       {}\n", countsText(counts.media));
    if (bounds)
        fmt::print("bounds      sphere of radius {:.4g} around {}\n", bounds->radius,
                   placeText(bounds->center, parts));
    if (const Vec3d& o = parts.origin; o != Vec3d(0.0))
        fmt::print("origin      rendered around ({:.10g}, {:.10g}, {:.10g}), for precision\n", o.x, o.y, o.z);
    for (const std::string& warning : parts.warnings) fmt::print("warning     {}\n", printable(warning));
}

void printJson(const SceneParts& parts, const Census& counts, const SceneBounds* bounds) {
    nlohmann::json result = {{"scene", parts.source},
                             {"integrator",
                              {{"type", parts.integrator.type},
                               {"max_depth", parts.limits.maxDepth},
                               {"rr_depth", parts.limits.rouletteDepth},
                               {"hide_emitters", parts.limits.hideEmitters}}},
                             {"shapes", counts.shapes},
                             {"primitives", counts.primitives},
                             {"instances", parts.instances.size()},
                             {"bsdfs", counts.bsdfs},
                             {"lights", counts.lights},
                             {"media", counts.media},
                             {"warnings", parts.warnings}};
    if (parts.camera) {
        const FilmWindow& w = parts.camera->window();
        const Vec3d eye = placeOf(parts.camera->position(), parts);
        result["film"] = {{"size", {w.fullWidth, w.fullHeight}},
                          {"crop", {w.x, w.y, w.width, w.height}},
                          {"filter", filterName(parts.filterKind)}};
        result["sensor"] = {{"type", kindOf(*parts.camera)}, {"position", {eye.x, eye.y, eye.z}}};
    }
    if (bounds) {
        const Vec3d center = placeOf(bounds->center, parts);
        result["bounds"] = {{"radius", bounds->radius}, {"center", {center.x, center.y, center.z}}};
    }
    result["origin"] = {parts.origin.x, parts.origin.y, parts.origin.z};
    fmt::print("{}\n", result.dump(2, ' ', true, nlohmann::json::error_handler_t::replace));
}

int info(const InfoArguments& a) {
    if (isImageFile(a.scene)) {
        const ImageInfo image = readImageInfo(a.scene);
        a.json ? printImageJson(image) : printImage(image);
        return kDone;
    }
    LoadOptions options;
    options.defines = parseDefines(a.defines);
    options.lenient = a.lenient;
    options.strict = a.strict;
    options.sensor = a.sensor;
    options.fragment = true;
    SceneParts parts = loadScene(a.scene, options);
    api::settle(parts, options);
    const Census counts = census(parts);
    const auto show = [&](const SceneParts& p, const SceneBounds* bounds) {
        a.json ? printJson(p, counts, bounds) : print(p, counts, bounds);
    };
    if (!parts.camera) {
        show(parts, nullptr);
        return kDone;
    }
    const Scene scene(std::move(parts));  // which may find more that is wrong
    show(scene.parts(), &scene.bounds());
    return kDone;
}

}  // namespace

Run addInfoCommand(CLI::App& parent) {
    CLI::App* app =
        parent.add_subcommand("info", "Show what was understood of a scene, or what an image says of itself");
    app->footer(kInfoExamples);
    auto a = std::make_shared<InfoArguments>();
    app->add_option("scene", a->scene, "Mitsuba scene (XML), glTF, pbrt, or an image")->required();
    app->add_option("-D,--define", a->defines, "Value for a <default> or $parameter of the scene")
        ->option_text("NAME=VALUE")
        ->allow_extra_args(false);
    app->add_option("--sensor", a->sensor,
                    "Which of several sensors: its number, from 0, or its id (default: 0)")
        ->option_text("N|ID");
    app->add_flag("--json", a->json, "Print JSON");
    addStrictnessOptions(*app, a->lenient, a->strict, "");
    return [a] { return info(*a); };
}

}  // namespace metrolux::core::app
