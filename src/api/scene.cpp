#include "api/internals.h"
#include "api/log.h"
#include "api/object_tree.h"

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
    for (const auto& [key, value] : options.defines) defines.push_back(key + "=" + value);
    nlohmann::json identity{{"name", name},
                            {"define", defines},
                            {"filter", options.film.filter.value_or("")},
                            {"lenient", options.lenient}};
    if (!options.sensor.empty()) identity["sensor"] = options.sensor;
    return identity;
}

/// Builds what `load` reads, with all its threads.
template <class Load>
Scene build(const LoadOptions& options, nlohmann::json identity, const Load& load) {
    core::ThreadLimit limit(options.threads);
    return limit.execute([&] {
        Scene::Impl impl;
        const core::LoadOptions o = core::api::coreOptions(options);
        core::SceneParts parts = load(o, impl);
        core::api::settle(parts, o);
        impl.film = o;
        impl.film.defines.clear();
        impl.warnings = parts.warnings;
        for (const std::string& warning : impl.warnings) core::api::log(LogLevel::Warning, warning);
        impl.scene = std::make_shared<const core::Scene>(std::move(parts));
        impl.identity = std::move(identity);
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
    return build(options, identityOf(file.filename().string(), options),
                 [&](const core::LoadOptions& o, Impl& impl) {
                     return core::loadScene(file, o, &impl.files, &impl.sensor);
                 });
}

Scene Scene::make(const Object& scene, const LoadOptions& options, const std::filesystem::path& folder) {
    if (!options.defines.empty()) throw core::Error("a scene that is made in code has nothing to define");
    core::mitsuba::ParsedScene parsed = core::api::parsedScene(scene, folder);
    nlohmann::json identity = identityOf("scene", options);
    identity["content"] = core::api::fingerprintOf(*parsed.root);
    return build(options, std::move(identity), [&](const core::LoadOptions& o, Impl& impl) {
        return core::buildScene(std::move(parsed), o, &impl.files, &impl.sensor);
    });
}

Scene Scene::withCamera(const Object& sensor) const {
    const std::shared_ptr<Element> element = core::api::parsedSensor(sensor);
    Impl impl = *impl_;
    if (filmOf(*element)) {
        impl.film.width = impl.film.height = 0;
        impl.film.hasCrop = false;
        impl.film.filter.clear();
        impl.identity["filter"] = "";
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
    if (change.maxDepth) view.limits.maxDepth = *change.maxDepth;
    if (change.rouletteDepth) view.limits.rouletteDepth = *change.rouletteDepth;
    if (change.hideEmitters) view.limits.hideEmitters = *change.hideEmitters;
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
