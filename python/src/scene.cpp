#include "scene.h"

#include "arrays.h"
#include "session.h"
#include "values.h"

#include <metrolux/error.h>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace metrolux::python {
namespace {

using Path = std::filesystem::path;
using Size = std::optional<std::pair<int, int>>;
using Window = std::optional<std::tuple<int, int, int, int>>;

FilmChange filmOf(const Size& resolution, const Window& crop, const std::optional<std::string>& filter) {
    FilmChange film;
    if (resolution) film.resolution = Resolution{resolution->first, resolution->second};
    if (crop) film.crop = std::apply([](int x, int y, int w, int h) { return Crop{x, y, w, h}; }, *crop);
    film.filter = filter;
    return film;
}

/// As the command has them after -D.
std::string defineText(const py::handle& value) {
    if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
    return py::str(value);
}

LoadOptions optionsOf(bool lenient, bool strict, const std::string& sensor, const FilmChange& film,
                      std::uint64_t memory, int threads) {
    LoadOptions options;
    options.lenient = lenient;
    options.strict = strict;
    options.sensor = sensor;
    options.film = film;
    options.memory = memory;
    options.threads = threads;
    return options;
}

Scene load(const Path& file, const py::object& define, bool lenient, bool strict, const std::string& sensor,
           const Size& resolution, const Window& crop, const std::optional<std::string>& filter,
           std::uint64_t memory, int threads, const py::kwargs& defines) {
    LoadOptions options =
        optionsOf(lenient, strict, sensor, filmOf(resolution, crop, filter), memory, threads);
    if (!define.is_none())
        for (const auto& [name, value] : define.cast<py::dict>())
            options.defines[name.cast<std::string>()] = defineText(value);
    for (const auto& [name, value] : defines) options.defines[name.cast<std::string>()] = defineText(value);
    const Unlocked unlocked;
    return Scene::load(file, options);
}

Scene loadDict(const py::dict& scene, const Path& folder, bool lenient, bool strict,
               const std::string& sensor, const Size& resolution, const Window& crop,
               const std::optional<std::string>& filter, std::uint64_t memory, int threads) {
    const Object object = objectFrom(scene, "");
    const LoadOptions options =
        optionsOf(lenient, strict, sensor, filmOf(resolution, crop, filter), memory, threads);
    const Unlocked unlocked;
    return Scene::make(object, options, folder);
}

Scene withCamera(const Scene& scene, const py::handle& camera) {
    if (py::isinstance<py::dict>(camera)) {
        const Object sensor = objectFrom(camera.cast<py::dict>(), "sensor");
        const Unlocked unlocked;
        return scene.withCamera(sensor);
    }
    const Transform toWorld = transformFrom(camera, "camera");
    const Unlocked unlocked;
    return scene.withCamera(toWorld);
}

Scene withValues(const Scene& scene, const py::dict& changes) {
    Object::Values values;
    for (const auto& [path, value] : changes) {
        const auto name = py::str(path).cast<std::string>();
        values.emplace_back(name, valueFrom(value, name));
    }
    const Unlocked unlocked;
    return scene.with(values);
}

py::dict valuesIn(const Scene& scene) {
    py::dict result;
    for (const auto& [path, value] : scene.values()) result[py::str(path)] = toPython(value);
    return result;
}

std::string textOf(const Scene& scene) {
    const SceneSizes sizes = scene.sizes();
    const Crop window = scene.window();
    return "<metrolux.Scene " + scene.source() + ", " + std::to_string(window.width) + "x" +
           std::to_string(window.height) + " pixels, " + std::to_string(sizes.primitives) + " primitives, " +
           std::to_string(sizes.lights) + " lights>";
}

/// What makes a session, besides its scene and the keywords of the integrator.
struct SessionArguments {
    std::string integrator;
    std::uint64_t seed;
    std::optional<int> maxDepth;
    std::uint64_t memory;
    std::vector<std::string> layers;
    std::uint32_t slices;
    std::optional<std::pair<std::uint32_t, std::uint32_t>> onlySlices;
    int threads;

    SessionOptions options(const py::kwargs& parameters) const {
        SessionOptions result;
        result.integrator = integrator;
        result.parameters = parametersFrom(parameters);
        result.seed = seed;
        result.maxDepth = maxDepth;
        result.memory = memory;
        result.layers = layers;
        result.slices.count = slices;
        if (onlySlices) {
            result.slices.first = onlySlices->first;
            result.slices.last = onlySlices->second;
        }
        result.threads = threads;
        return result;
    }
};

/// What the session leaves: the image, with layers and statistics as attributes.
py::object imageFrom(PythonSession& session) {
    const std::string statistics = session.use([](Session& s) { return s.statistics(); });
    Picture picture = [&] {
        const Unlocked unlocked;
        return session.release().finish();
    }();
    py::object image = imageOf(std::move(picture.image));
    py::dict layers;
    for (auto& [name, layer] : picture.layers) layers[py::str(name)] = imageOf(std::move(layer));
    image.attr("layers") = layers;
    image.attr("statistics") = fromJson(statistics);
    return image;
}

/// The image, or None before the first pass.
py::object imageIfAny(PythonSession& session) {
    return session.use([](Session& s) { return s.progress().passes > 0; }) ? imageFrom(session) : py::none();
}

py::object render(const Scene& scene, const SessionArguments& arguments, const LimitArguments& limits,
                  const FileArguments& files, const py::object& progress, const std::optional<Path>& resume,
                  const py::kwargs& parameters) {
    PythonSession session(scene, arguments.options(parameters), limits.limits());
    if (resume) session.use([&](Session& s) { s.resume(*resume); });
    try {
        session.run(session.limits(), progress, files.files());
    } catch (py::error_already_set& problem) {
        rethrowWithImage(problem, imageIfAny(session));
    } catch (const Error& problem) {  // of files: the image is there all the same
        const py::object type = py::module_::import("metrolux").attr("Error");
        const py::object error = type(problem.what());
        error.attr("image") = imageIfAny(session);
        PyErr_SetObject(type.ptr(), error.ptr());
        throw py::error_already_set();
    }
    return imageFrom(session);
}

constexpr const char* kLoadDoc = R"(Reads a Mitsuba scene (XML of version 3.x, 2.x, 0.6 or 0.5).

define, and all further keywords: values of the scene's <default>s and $parameters, such as spp=16.
lenient: unknown plugins and parameters are warned of, not refused. strict: any warning is an Error.
sensor: number or id of one of several. resolution: (width, height) in pixels, crop: (x, y, width, height) in pixels
of the full image, filter: box, tent, gaussian, mitchell, catmullrom or lanczos, in place of the film's.
memory: bytes that the scene's data may take, 0 for what the machine has. threads: 0 for one per core.)";

constexpr const char* kLoadDictDoc = R"(A scene of nested dictionaries in the form of Mitsuba 3's load_dict.

Each has a "type" and the parameters of that plugin. Numbers, strings and bools are values; sequences or arrays of
three numbers are points and vectors; a Transform or an array (4, 4) is a transform; {"type": "rgb", "value": ...}
and {"type": "spectrum", "value": number or [(nanometers, value), ...]} are colors; {"type": "ref", "id": ...} refers
to another object; {"type": "mesh", "arrays": Mesh(...)} has a mesh's arrays; {"type": "bitmap", "data": array}, and
an envmap, have linear pixels (height, width, channels) in place of a file.
folder: where files are looked for, the working directory if empty. The rest is as in load().)";

constexpr const char* kValuesDoc = R"(What the scene says, a dict by path: "lamp.emitter.radiance".

A path is made of names with points between: directly in the scene an id (or the tag, "shape"), below it the name in
the parent (or the tag). Where a name repeats, "_2", "_3" ... follow it. Defaults are not listed.)";

constexpr const char* kWithValuesDoc = R"(The scene with other values at paths as `values` has them.

A name that its parent does not have is added. A dictionary takes the place of an object, for all who refer to it.
Three numbers in place of a color or a number are a color, linear Rec.709. What is outside of the sensor is built
again, geometry included, and files are read again.)";

constexpr const char* kSessionDoc = R"(A Session of this scene, to be rendered step by step.

Limits (time in seconds, passes, error) end an iteration, and a Session.render() that has none of its own. All other
arguments are as in render().)";

/// With the names of all integrators.
std::string renderDoc() {
    std::string names;
    for (const IntegratorDescription& integrator : integrators())
        names += "\n    " + integrator.name + ": " + integrator.summary;
    return R"(Renders, and gives the Image: float32 (height, width, 3), linear Rec.709.

The same bits as those of `metrolux render` with the same arguments, on any number of threads.

Limits, of which the first that is reached counts: time in seconds of rendering, passes, error (estimated root of the
mean squared relative error of the image). Without any: a minute.
max_depth: most path edges, in place of the scene's limit; -1 for no limit. memory: bytes that an iteration may store.
layers: names of docs/reference/layers.md; image.layers has them, float32 (height, width, channels).
slices, only_slices: as in `metrolux render`; parts are joined by merge().
threads: 0 for one per core. progress: called with a Progress after each pass; False ends the rendering.
output: one or several files, .exr or .png (through exposure, in stops, and curve, srgb or filmic), written every
save_every seconds (0: at the end only) and at the end; overwrite: those of other programs too.
checkpoint: a file that the state is written to every checkpoint_every seconds and at the end; resume: one to go on
from.
Further keywords are parameters of the integrator; integrators() describes them.

Ctrl-C ends the pass in progress, writes the files and raises Interrupted, a KeyboardInterrupt, whose `image` has
what was rendered. So has what the progress function raises.

Integrators:)" +
           names;
}

void defineMethods(py::class_<Scene>& type) {
    type.def(
            "session",
            [](const Scene& scene, const std::string& integrator, std::optional<double> time,
               std::optional<std::uint32_t> passes, std::optional<double> error, std::uint64_t seed,
               std::optional<int> maxDepth, const std::vector<std::string>& layers, int threads,
               std::uint64_t memory, std::uint32_t slices,
               std::optional<std::pair<std::uint32_t, std::uint32_t>> onlySlices,
               const py::kwargs& parameters) {
                const SessionArguments a{integrator, seed,   maxDepth,   memory,
                                         layers,     slices, onlySlices, threads};
                return std::make_shared<PythonSession>(scene, a.options(parameters),
                                                       LimitArguments{time, passes, error}.limits());
            },
            py::arg("integrator") = kDefaultIntegrator, py::kw_only(), py::arg("time") = py::none(),
            py::arg("passes") = py::none(), py::arg("error") = py::none(), py::arg("seed") = 0,
            py::arg("max_depth") = py::none(), py::arg("layers") = py::tuple(), py::arg("threads") = 0,
            py::arg("memory") = kDefaultMemory, py::arg("slices") = 1, py::arg("only_slices") = py::none(),
            kSessionDoc)
        .def(
            "render",
            [](const Scene& scene, const std::string& integrator, std::optional<double> time,
               std::optional<std::uint32_t> passes, std::optional<double> error, std::uint64_t seed,
               std::optional<int> maxDepth, const std::vector<std::string>& layers, int threads,
               std::uint64_t memory, std::uint32_t slices,
               std::optional<std::pair<std::uint32_t, std::uint32_t>> onlySlices, const py::object& progress,
               const py::object& output, bool overwrite, double exposure, const std::string& curve,
               double saveEvery, std::optional<Path> checkpoint, double checkpointEvery,
               std::optional<Path> resume, const py::kwargs& parameters) {
                const SessionArguments a{integrator, seed,   maxDepth,   memory,
                                         layers,     slices, onlySlices, threads};
                const FileArguments files{output,    overwrite,  exposure,       curve,
                                          saveEvery, checkpoint, checkpointEvery};
                return render(scene, a, {time, passes, error}, files, progress, resume, parameters);
            },
            py::arg("integrator") = kDefaultIntegrator, py::kw_only(), py::arg("time") = py::none(),
            py::arg("passes") = py::none(), py::arg("error") = py::none(), py::arg("seed") = 0,
            py::arg("max_depth") = py::none(), py::arg("layers") = py::tuple(), py::arg("threads") = 0,
            py::arg("memory") = kDefaultMemory, py::arg("slices") = 1, py::arg("only_slices") = py::none(),
            py::arg("progress") = py::none(), py::arg("output") = py::none(), py::arg("overwrite") = false,
            py::arg("exposure") = 0.0, py::arg("curve") = "srgb", py::arg("save_every") = kDefaultSaveEvery,
            py::arg("checkpoint") = py::none(), py::arg("checkpoint_every") = kDefaultCheckpointEvery,
            py::arg("resume") = py::none(), renderDoc().c_str());
}

}  // namespace

void defineScene(py::module_& module) {
    py::class_<Scene> type(module, "Scene", R"(A scene that can be rendered; load() and load_dict() make one.

It never changes: what "changes" it makes another one, which shares all that is the same.)");
    type.attr("__module__") = "metrolux";
    type.def("with_camera", &withCamera, py::arg("camera"), R"(The scene seen from elsewhere, geometry shared.

camera: the `to_world` of its sensor (a Transform or an array (4, 4)), or a dictionary of another sensor, which has
this one's film unless it brings one.)")
        .def(
            "with_film",
            [](const Scene& scene, const Size& resolution, const Window& crop,
               const std::optional<std::string>& filter) {
                const Unlocked unlocked;
                return scene.withFilm(filmOf(resolution, crop, filter));
            },
            py::kw_only(), py::arg("resolution") = py::none(), py::arg("crop") = py::none(),
            py::arg("filter") = py::none(),
            "With another resolution, crop or filter, as in load(); geometry shared.")
        .def(
            "with_paths",
            [](const Scene& scene, std::optional<int> maxDepth, std::optional<int> rouletteDepth,
               std::optional<bool> hideEmitters) {
                const Unlocked unlocked;
                return scene.withPaths({maxDepth, rouletteDepth, hideEmitters});
            },
            py::kw_only(), py::arg("max_depth") = py::none(), py::arg("roulette_depth") = py::none(),
            py::arg("hide_emitters") = py::none(), R"(With other limits of its integrator; geometry shared.

max_depth: most path edges, -1 for no limit, 2 is direct light. roulette_depth: edges of a subpath before Russian
roulette. hide_emitters: lights are not seen directly.)")
        .def("with_values", &withValues, py::arg("changes"), kWithValuesDoc)
        .def_property_readonly("values", &valuesIn, kValuesDoc)
        .def_property_readonly(
            "resolution",
            [](const Scene& s) { return std::pair(s.resolution().width, s.resolution().height); },
            "(width, height) of the full image, in pixels")
        .def_property_readonly(
            "window",
            [](const Scene& s) {
                const Crop w = s.window();
                return std::tuple(w.x, w.y, w.width, w.height);
            },
            "(x, y, width, height) of the part of it that is rendered")
        .def_property_readonly(
            "sizes",
            [](const Scene& s) {
                const SceneSizes sizes = s.sizes();
                return py::dict(py::arg("shapes") = sizes.shapes, py::arg("instances") = sizes.instances,
                                py::arg("primitives") = sizes.primitives, py::arg("lights") = sizes.lights);
            },
            "a dict: shapes, instances, primitives, lights")
        .def_property_readonly("integrator", &Scene::integrator,
                               "the type of the scene's <integrator>, path without one")
        .def_property_readonly("warnings", &Scene::warnings,
                               "what is understood but has no effect, or was let pass")
        .def_property_readonly("source", &Scene::source, "name of the file, or \"scene\"")
        .def("shares_geometry_with", &Scene::sharesGeometryWith, py::arg("other"),
             "Whether both have the same geometry in memory.")
        .def("__repr__", &textOf);
    defineMethods(type);
    module.def("load", &load, py::arg("file"), py::kw_only(), py::arg("define") = py::none(),
               py::arg("lenient") = false, py::arg("strict") = false, py::arg("sensor") = "",
               py::arg("resolution") = py::none(), py::arg("crop") = py::none(),
               py::arg("filter") = py::none(), py::arg("memory") = 0, py::arg("threads") = 0, kLoadDoc);
    module.def("load_dict", &loadDict, py::arg("scene"), py::kw_only(), py::arg("folder") = "",
               py::arg("lenient") = false, py::arg("strict") = false, py::arg("sensor") = "",
               py::arg("resolution") = py::none(), py::arg("crop") = py::none(),
               py::arg("filter") = py::none(), py::arg("memory") = 0, py::arg("threads") = 0, kLoadDictDoc);
}

}  // namespace metrolux::python
