#include "api/internals.h"
#include "api/log.h"
#include "api/object_tree.h"
#include "api/scene_tree.h"
#include "base/printable.h"

namespace metrolux {
namespace {

using core::mitsuba::Element;
using core::mitsuba::ElementPtr;
using core::mitsuba::Property;

void apply(const FilmChange& change, core::LoadOptions& film) {
    if (change.resolution) film.setResolution(change.resolution->width, change.resolution->height);
    if (change.crop) film.setCrop(change.crop->x, change.crop->y, change.crop->width, change.crop->height);
    if (change.filter) film.filter = *change.filter;
}

void apply(const PathChange& change, core::PathLimits& limits) {
    if (change.maxDepth) limits.maxDepth = *change.maxDepth;
    if (change.rouletteDepth) limits.rouletteDepth = *change.rouletteDepth;
    if (change.hideEmitters) limits.hideEmitters = *change.hideEmitters;
}

void apply(const PathChange& change, PathChange& before) {
    if (change.maxDepth) before.maxDepth = change.maxDepth;
    if (change.rouletteDepth) before.rouletteDepth = change.rouletteDepth;
    if (change.hideEmitters) before.hideEmitters = change.hideEmitters;
}

}  // namespace

core::LoadOptions core::api::coreOptions(const metrolux::LoadOptions& options) {
    LoadOptions result;
    result.defines = options.defines;
    result.lenient = options.lenient;
    result.strict = options.strict;
    result.sensor = options.sensor;
    result.memoryBytes = options.memory;
    apply(options.film, result);
    return result;
}

void core::api::settle(SceneParts& parts, const LoadOptions& options) {
    settleSceneIntegrator(parts, options.lenient);
    if (options.strict) refuseWarnings(parts);
}

namespace {

nlohmann::json identityOf(const std::string& name, const LoadOptions& options) {
    std::vector<std::string> defines;
    for (const auto& [key, value] : options.defines) defines.push_back(core::validUtf8(key + "=" + value));
    nlohmann::json identity{{"name", core::validUtf8(name)},
                            {"define", defines},
                            {"filter", options.film.filter.value_or("")},
                            {"lenient", options.lenient}};
    if (!options.sensor.empty()) identity["sensor"] = core::validUtf8(options.sensor);
    return identity;
}

void warnOfFaintLight(const core::Scene& scene) {
    constexpr int kFaintest = -100;
    if (const int exponent = scene.emissionExponent(); exponent < kFaintest)
        core::api::log(
            LogLevel::Warning,
            fmt::format("the light of the scene is of the size of 2^{}: textures that emit so little, and "
                        "pixels, lose digits of single precision",
                        exponent));
}

/// Makes a scene of what `load` reads into `impl`, with so many threads.
template <class Load>
Scene build(Scene::Impl impl, int threads, const Load& load) {
    core::ThreadLimit limit(threads);
    return limit.execute([&] {
        const int64_t begin = core::fileClock();
        core::SceneParts parts = load(impl);
        impl.stamps.clear();
        for (const std::filesystem::path& file : impl.files) {
            const core::FileStamp stamp = core::stampOf(file);
            const bool changedMeanwhile = stamp.modified > begin && stamp.modified <= core::fileClock();
            impl.stamps.push_back(changedMeanwhile ? core::FileStamp() : stamp);
        }
        core::api::settle(parts, impl.film);
        impl.warnings = parts.warnings;
        for (const std::string& warning : impl.warnings) core::api::log(LogLevel::Warning, warning);
        impl.scene = std::make_shared<const core::Scene>(std::move(parts));
        warnOfFaintLight(*impl.scene);
        impl.treeSensor = impl.sensor.element;
        return Internals::wrap(std::move(impl));
    });
}

const Property* filmOf(const Element& sensor) {
    const auto isFilm = [](const Property& p) {
        const ElementPtr* element = std::get_if<ElementPtr>(&p.value);
        return element && *element && (*element)->tag == "film";
    };
    for (const auto& [name, property] : sensor.named)
        if (isFilm(property)) return &property;
    for (const Property& property : sensor.children)
        if (isFilm(property)) return &property;
    return nullptr;
}

void forgetFilmChanges(Scene::Impl& impl) {
    impl.film.width = impl.film.height = 0;
    impl.film.hasCrop = false;
    impl.film.filter.clear();
    impl.identity["filter"] = "";
}

/// The scene of `from` seen as `impl` says by now.
Scene viewed(const core::Scene& from, Scene::Impl impl) {
    std::vector<std::string> warnings;
    core::SceneView view = core::makeView(impl.sensor, impl.film, warnings);
    view.limits = from.parts().limits;
    for (std::string& warning : warnings) {
        if (std::find(impl.warnings.begin(), impl.warnings.end(), warning) != impl.warnings.end()) continue;
        core::api::log(LogLevel::Warning, warning);
        impl.warnings.push_back(std::move(warning));
    }
    impl.scene = std::make_shared<const core::Scene>(from, std::move(view));
    return Internals::wrap(std::move(impl));
}

}  // namespace

Scene Scene::load(const std::filesystem::path& file, const LoadOptions& options) {
    Impl impl;
    impl.film = core::api::coreOptions(options);
    impl.identity = identityOf(file.filename().string(), options);
    return build(std::move(impl), options.threads, [&](Impl& scene) {
        core::mitsuba::ParsedScene tree;
        core::SceneParts parts = core::loadScene(file, scene.film, &scene.files, &scene.sensor, &tree);
        scene.tree = std::make_shared<const core::mitsuba::ParsedScene>(std::move(tree));
        scene.film.defines.clear();
        return parts;
    });
}

Scene Scene::make(const Object& scene, const LoadOptions& options, const std::filesystem::path& folder) {
    if (!options.defines.empty()) throw core::Error("a scene that is made in code has nothing to define");
    Impl impl;
    impl.film = core::api::coreOptions(options);
    impl.tree = std::make_shared<const core::mitsuba::ParsedScene>(core::api::parsedScene(scene, folder));
    impl.identity = identityOf("scene", options);
    impl.identity["content"] = core::api::fingerprintOf(*impl.tree->root);
    return build(std::move(impl), options.threads, [](Impl& made) {
        return core::buildScene(*made.tree, made.film, &made.files, &made.sensor);
    });
}

Scene Scene::with(const Object::Values& changes) const {
    core::api::SceneTree tree(*impl_->tree, impl_->treeSensor, impl_->sensor.element);
    for (const auto& [path, value] : changes) tree.set(path, value);
    core::mitsuba::ParsedScene changed = tree.finish();
    Impl impl = *impl_;
    if (tree.filmChanged()) forgetFilmChanges(impl);
    if (tree.onlySensorChanged()) {
        impl.sensor.element = tree.sensor();
        impl.identity["camera"] = core::api::fingerprintOf(*tree.sensor());
        return viewed(*impl_->scene, std::move(impl));
    }
    impl.identity["content"] = core::api::fingerprintOf(*changed.root);
    impl.identity.erase("camera");
    impl.tree = std::make_shared<const core::mitsuba::ParsedScene>(std::move(changed));
    return build(std::move(impl), 0, [&](Impl& scene) {
        core::SceneParts parts = core::buildScene(*scene.tree, scene.film, &scene.files, &scene.sensor);
        parts.source = source();
        apply(scene.paths, parts.limits);
        return parts;
    });
}

Object::Values Scene::values() const {
    return core::api::valuesOf(*impl_->tree->root, impl_->treeSensor.get(), *impl_->sensor.element);
}

Scene Scene::withCamera(const Object& sensor) const {
    const std::shared_ptr<Element> element = core::api::parsedSensor(sensor);
    Impl impl = *impl_;
    if (filmOf(*element)) {
        forgetFilmChanges(impl);
    } else if (const Property* film = filmOf(*impl.sensor.element)) {
        element->children.push_back(*film);
    }
    impl.sensor.element = element;
    impl.identity["camera"] = core::api::fingerprintOf(*element);
    return viewed(*impl_->scene, std::move(impl));
}

Scene Scene::withCamera(const Transform& toWorld) const {
    Impl impl = *impl_;
    auto element = std::make_shared<Element>(*impl.sensor.element);
    std::erase_if(element->named, [](const auto& entry) { return entry.first == "to_world"; });
    element->named.emplace_back("to_world",
                                Property{Internals::transform(toWorld), element->location, false, 0});
    impl.sensor.element = element;
    impl.identity["camera"] = core::api::fingerprintOf(*element);
    return viewed(*impl_->scene, std::move(impl));
}

Scene Scene::withFilm(const FilmChange& change) const {
    Impl impl = *impl_;
    apply(change, impl.film);
    impl.identity["filter"] = impl.film.filter;
    return viewed(*impl_->scene, std::move(impl));
}

Scene Scene::withPaths(const PathChange& change) const {
    Impl impl = *impl_;
    const core::SceneParts& parts = impl_->scene->parts();
    core::SceneView view{parts.camera, parts.limits, parts.filterKind, parts.filter};
    apply(change, impl.paths);
    apply(change, view.limits);
    if (view.limits.maxDepth < -1)
        throw core::Error("the largest depth is {}, expected -1 or more", view.limits.maxDepth);
    if (view.limits.rouletteDepth < 1)
        throw core::Error("roulette after {} edges, expected 1 or more", view.limits.rouletteDepth);
    impl.scene = std::make_shared<const core::Scene>(*impl_->scene, std::move(view));
    return Internals::wrap(std::move(impl));
}

bool Scene::sharesGeometryWith(const Scene& other) const {
    return &impl_->scene->intersector() == &other.impl_->scene->intersector();
}

Resolution Scene::resolution() const {
    const core::FilmWindow& w = impl_->scene->camera().window();
    return {w.fullWidth, w.fullHeight};
}

Crop Scene::window() const {
    const core::FilmWindow& w = impl_->scene->camera().window();
    return {w.x, w.y, w.width, w.height};
}

SceneSizes Scene::sizes() const {
    const core::SceneParts& parts = impl_->scene->parts();
    SceneSizes sizes{parts.shapes.size(), parts.instances.size(), 0, parts.lights.size()};
    for (const core::ShapePtr& shape : parts.shapes) sizes.primitives += shape->primitiveCount();
    for (const core::Instance& instance : parts.instances)
        for (const core::ShapePtr& shape : instance.group->shapes)
            sizes.primitives += shape->primitiveCount();
    return sizes;
}

std::string Scene::integrator() const { return impl_->scene->parts().integrator.type; }
const std::vector<std::string>& Scene::warnings() const { return impl_->warnings; }
std::string Scene::source() const { return impl_->scene->parts().source; }

}  // namespace metrolux
