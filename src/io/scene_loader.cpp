#include "io/scene_loader.h"

#include "io/gltf/scene.h"
#include "io/mitsuba/context.h"
#include "io/mitsuba/media.h"
#include "io/mitsuba/parser.h"
#include "io/mitsuba/repetitions.h"
#include "io/mitsuba/world_origin.h"
#include "io/pbrt/scene.h"

namespace metrolux::core {
namespace {

using namespace mitsuba;

}  // namespace

void refuseWarnings(const SceneParts& parts) {
    if (parts.warnings.empty()) return;
    const size_t more = parts.warnings.size() - 1;
    throw Error("{}{}", parts.warnings.front(), more ? fmt::format(" (and {} more warnings)", more) : "");
}

namespace {

LoadContext contextOf(const LoadOptions& options, const MemoryBudget& memory,
                      const std::vector<std::filesystem::path>& searchPaths) {
    LoadContext context;
    context.memory = memory;
    context.searchPaths = searchPaths;
    context.lenient = options.lenient;
    context.film = {options.width, options.height,    options.hasCrop,   options.cropX,
                    options.cropY, options.cropWidth, options.cropHeight};
    return context;
}

class Loader {
  public:
    Loader(ParsedScene parsed, const LoadOptions& options, const MemoryBudget& memory, const Vec3d& origin)
        : scene_(std::move(parsed)), context_(contextOf(options, memory, scene_.searchPaths)) {
        context_.origin = context_.sceneOrigin = parts_.origin = origin;
        isFragment_ = options.fragment;
        chosenSensor_ = options.sensor;
        context_.warnings = std::move(scene_.warnings);
    }

    /// Files that were read besides the scene's own; after run().
    std::set<std::filesystem::path> files() const {
        std::set<std::filesystem::path> result = context_.files;
        result.insert(scene_.files.begin(), scene_.files.end());
        return result;
    }

    /// What the camera was made from; after run().
    SensorSource sensorSource() const {
        return {sensor_, context_.searchPaths, context_.lenient, context_.origin, context_.mediumIndices};
    }

    SceneParts run(const std::string& source) {
        integrator();
        sensor();
        emitters();
        for (const ElementPtr& shape : scene_.root->childrenOf("shape"))
            build(*shape, [&] { addShape(*shape, context_, parts_); });
        checkLights();
        unused();
        parts_.source = source;
        parts_.media = std::move(context_.media);
        parts_.warnings = withRepetitionsCounted(context_.warnings);
        return std::move(parts_);
    }

  private:
    /// Runs a factory; whatever it throws becomes an Error that says where. Elements name their own place,
    /// which may be another than this one's, when they are nested or referenced.
    template <class Action>
    void build(const Element& element, const Action& action) const {
        try {
            action();
        } catch (const Error& problem) {
            const std::string message = problem.what();
            if (message.starts_with(scene_.root->location.file + ":")) throw;
            for (const std::string& file : scene_.files)
                if (message.starts_with(file + ":")) throw;
            throw element.error(message);
        } catch (const std::bad_alloc&) {
            throw element.error("not enough memory");
        } catch (const std::exception& problem) {
            throw element.error(problem.what());
        }
    }

    void integrator() {
        const auto integrators = scene_.root->childrenOf("integrator");
        if (integrators.size() > 1)
            throw integrators[1]->error(fmt::format("found a second integrator, expected one (first at {})",
                                                    integrators[0]->location.str()));
        for (const ElementPtr& element : integrators)
            build(*element, [&] { readIntegrator(*element, context_, parts_); });
    }

    void sensor() {
        const auto sensors = scene_.root->childrenOf("sensor");
        if (sensors.empty() && isFragment_) {
            context_.warn(*scene_.root, "found no <sensor>: there is nothing to render yet");
            return;
        }
        if (sensors.empty()) throw scene_.root->error("found no <sensor>, expected one");
        if (sensors.size() > 1 && chosenSensor_.empty())
            context_.warn(*sensors[1],
                          fmt::format("{} sensors, the first is used; --sensor chooses", sensors.size()));
        sensor_ = chosenSensor_.empty() ? sensors[0] : findSensor(sensors);
        build(*sensor_, [&] { parts_.camera = makeCamera(*sensor_, context_, parts_); });
    }

    ElementPtr findSensor(const std::vector<ElementPtr>& sensors) const {
        std::string list;
        for (size_t i = 0; i < sensors.size(); ++i) {
            const std::string& id = sensors[i]->id;
            if (chosenSensor_ == id || chosenSensor_ == std::to_string(i)) return sensors[i];
            list +=
                fmt::format("{}{}{}", i > 0 ? ", " : "", i, id.empty() ? "" : fmt::format(" (\"{}\")", id));
        }
        throw scene_.root->error(fmt::format("--sensor {}: expected one of {}", chosenSensor_, list));
    }

    void emitters() {
        for (const ElementPtr& element : scene_.root->childrenOf("emitter")) {
            if (element->type == "area") {  // belongs to the shapes that refer to it
                if (!scene_.referenced.contains(element.get()))
                    context_.warn(*element, "no shape refers to it: it has no effect");
                continue;
            }
            build(*element, [&] {
                LightPtr light = makeLight(*element, context_);
                if (!light) return;
                if (light->isEnvironment()) {
                    if (environment_)
                        throw element->error(
                            fmt::format("found a second environment emitter, expected one (first at {})",
                                        environment_->location.str()));
                    environment_ = element;
                }
                parts_.lights.push_back(std::move(light));
            });
        }
    }

    void checkLights() {
        if (parts_.lights.empty())
            context_.warn(*scene_.root, "the scene has no emitter: the image will be black");
    }

    /// What nothing refers to is built all the same, so that its errors show; what cannot stand alone must be
    /// referred to.
    void unused() {
        for (const ElementPtr& element : scene_.root->childrenOf("bsdf"))
            if (!scene_.referenced.contains(element.get()))
                build(*element, [&] { makeBsdf(*element, context_); });
        for (const ElementPtr& element : scene_.root->childrenOf("texture"))
            if (!scene_.referenced.contains(element.get()))
                build(*element, [&] { makeTexture(*element, context_); });
        for (const ElementPtr& element : scene_.root->childrenOf("volume"))
            if (!scene_.referenced.contains(element.get()))
                build(*element, [&] { makeVolume(*element, context_); });
        for (const ElementPtr& element : scene_.root->childrenOf("phase"))
            if (!scene_.referenced.contains(element.get()))
                build(*element, [&] { makePhase(*element, context_); });
        for (const ElementPtr& element : scene_.root->childrenOf("medium")) {
            if (context_.mediumIndices.contains(element.get())) continue;
            build(*element, [&] { makeMedium(*element, context_); });
            context_.warn(*element,
                          "no shape, sensor or emitter that is used refers to it: it has no effect");
        }
        for (const char* tag : {"film", "rfilter", "sampler"})
            for (const ElementPtr& element : scene_.root->childrenOf(tag))
                if (!scene_.referenced.contains(element.get())) misplaced(*element);
        scene_.root->childrenOf("subsurface");  // of shapes that refer to it
        // How Mitsuba 3 traces rays.
        for (const char* name : {"embree_use_robust_intersections", "allow_thread_reordering"})
            if (!scene_.root->isLegacy()) scene_.root->ignore(name);
        scene_.root->checkAllUsed(context_.lenient, context_.warnings);
    }

    /// Mitsuba 3 passes over what a scene does not need, 0.6 over samplers only.
    void misplaced(const Element& element) {
        if (element.isLegacy() && element.tag != "sampler" && !context_.lenient)
            throw element.error("found directly inside <scene>, expected inside of a <sensor> or its <film>");
        context_.warn(element, "is part of no <sensor>: it has no effect");
    }

    bool isFragment_ = false;
    std::string chosenSensor_;
    ParsedScene scene_;
    LoadContext context_;
    SceneParts parts_;
    ElementPtr environment_, sensor_;
};

MemoryBudget memoryFor(const LoadOptions& options) {
    if (options.memoryBytes > 0) return MemoryBudget(options.memoryBytes);
    const uint64_t machine = physicalMemoryBytes();
    return machine > 0 ? MemoryBudget(machine) : MemoryBudget::unlimited();
}

ParsedScene parseFile(const std::filesystem::path& file, const LoadOptions& options, MemoryBudget& memory) {
    const bool isGltf = gltf::isGltf(file), isPbrt = pbrt::isPbrt(file);
    if (!isGltf && !isPbrt) return parseScene(file, options.defines, options.lenient, &memory);
    if (!options.defines.empty())
        throw Error("{}: a {} file has no parameters, found the value of \"{}\"", file.string(),
                    isGltf ? "glTF" : "pbrt", options.defines.begin()->first);
    return isGltf ? gltf::parseGltf(file, options.lenient, memory)
                  : pbrt::parsePbrt(file, options.lenient, memory);
}

template <class Film>
void overrideFilter(Film& film, const LoadOptions& options) {
    if (options.filter.empty()) return;
    film.filterKind = filterKind(options.filter);
    film.filter = {};
}

SceneParts build(ParsedScene parsed, const LoadOptions& options, const MemoryBudget& memory,
                 const std::string& source, std::vector<std::filesystem::path>* files, SensorSource* sensor) {
    // As long as what was read is elsewhere than thought, it is read once more: one time, or twice.
    constexpr int kAttempts = 3;
    Vec3d origin = guessedOrigin(*parsed.root);
    std::optional<Loader> loader;
    SceneParts parts;
    for (int attempt = 1; attempt <= kAttempts; ++attempt) {
        loader.emplace(parsed, options, memory, origin);
        parts = loader->run(source);
        const Vec3d better = originFor(boxesOf(parts.shapes, parts.instances), origin);
        if (better == origin) break;
        origin = better;
        if (attempt == kAttempts) break;
        parts = {};
        forgetReads(*parsed.root);
    }
    if (options.strict) refuseWarnings(parts);
    overrideFilter(parts, options);
    if (files)
        for (const std::filesystem::path& read : loader->files())
            if (read != source) files->push_back(read);
    if (sensor) *sensor = loader->sensorSource();
    return parts;
}

/// A copy whose properties count as unread. Another thread may be reading the original.
ElementPtr copyOf(const Element& element) {
    auto result = std::make_shared<Element>(element);
    const auto renew = [](Property& property) {
        property.used = false;
        // What the scene has made of a medium is found by its element.
        if (ElementPtr* child = std::get_if<ElementPtr>(&property.value);
            child && *child && (*child)->tag != "medium")
            *child = copyOf(**child);
    };
    for (auto& entry : result->named) renew(entry.second);
    for (Property& property : result->children) renew(property);
    return result;
}

}  // namespace

void LoadOptions::setResolution(int newWidth, int newHeight) {
    constexpr int kLargestSide = 65536;
    if (newWidth < 1 || newHeight < 1 || newWidth > kLargestSide || newHeight > kLargestSide)
        throw Error("resolution {}x{}: both sides must be from 1 to {} pixels", newWidth, newHeight,
                    kLargestSide);
    width = newWidth;
    height = newHeight;
}

void LoadOptions::setCrop(int x, int y, int newWidth, int newHeight) {
    if (x < 0 || y < 0 || newWidth < 1 || newHeight < 1)
        throw Error("crop {},{},{},{}: x and y must not be negative, width and height not less than 1", x, y,
                    newWidth, newHeight);
    hasCrop = true;
    cropX = x;
    cropY = y;
    cropWidth = newWidth;
    cropHeight = newHeight;
}

SceneParts loadScene(const std::filesystem::path& file, const LoadOptions& options,
                     std::vector<std::filesystem::path>* files, SensorSource* sensor, ParsedScene* tree) {
    MemoryBudget memory = memoryFor(options);
    ParsedScene parsed = parseFile(file, options, memory);
    if (tree) *tree = parsed;
    if (files) files->assign(1, file);
    return build(std::move(parsed), options, memory, file.string(), files, sensor);
}

ParsedScene parseSceneFile(const std::filesystem::path& file, const LoadOptions& options) {
    MemoryBudget memory = memoryFor(options);
    return parseFile(file, options, memory);
}

std::vector<std::string> sensorNames(const std::filesystem::path& file, const LoadOptions& options) {
    MemoryBudget memory = memoryFor(options);
    std::vector<std::string> names;
    for (const ElementPtr& sensor : parseFile(file, options, memory).root->childrenOf("sensor"))
        names.push_back(sensor->id.empty() ? std::to_string(names.size()) : sensor->id);
    return names;
}

SceneParts buildScene(ParsedScene parsed, const LoadOptions& options,
                      std::vector<std::filesystem::path>* files, SensorSource* sensor) {
    if (files) files->clear();
    const std::string source = std::filesystem::path(parsed.root->location.file).filename().string();
    return build(std::move(parsed), options, memoryFor(options), source, files, sensor);
}

SceneView makeView(const SensorSource& source, const LoadOptions& options,
                   std::vector<std::string>& warnings) {
    LoadContext context = contextOf(options, memoryFor(options), source.searchPaths);
    context.lenient = source.lenient;
    context.origin = context.sceneOrigin = source.origin;
    context.mediumIndices = source.media;
    SceneParts film;
    const ElementPtr element = copyOf(*source.element);
    CameraPtr camera = makeCamera(*element, context, film);
    if (!context.media.empty())
        throw element->error(
            "found a medium that is not one of the scene's, expected a view of what is there");
    overrideFilter(film, options);
    warnings = std::move(context.warnings);
    return {std::move(camera), {}, film.filterKind, film.filter};
}

}  // namespace metrolux::core
