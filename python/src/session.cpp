#include "session.h"

#include "arrays.h"

#include <metrolux/error.h>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace metrolux::python {
namespace {

using Handle = std::shared_ptr<PythonSession>;

PythonSession& of(const py::object& self) { return self.cast<PythonSession&>(); }

py::object imageIn(const py::object& self) {
    return viewOf(of(self).use([](Session& s) { return s.image(); }), self);
}

py::dict layersIn(const py::object& self) {
    py::dict layers;
    for (const std::string& name : of(self).use([](Session& s) { return s.options().layers; }))
        layers[py::str(name)] = viewOf(of(self).use([&](Session& s) { return s.layer(name); }), self);
    return layers;
}

/// Runs `action`; what Python raises in it brings the image along.
template <class Action>
py::object rendered(const py::object& self, const Action& action) {
    try {
        action(of(self));
    } catch (py::error_already_set& problem) {
        rethrowWithImage(problem, imageIn(self));
    }
    return imageIn(self);
}

py::object render(const py::object& self, std::optional<double> time, std::optional<std::uint32_t> passes,
                  std::optional<double> error, const py::object& progress, const py::object& output,
                  bool overwrite, double exposure, const std::string& curve, double saveEvery,
                  std::optional<std::filesystem::path> checkpoint, double checkpointEvery) {
    const FileArguments files{output, overwrite, exposure, curve, saveEvery, checkpoint, checkpointEvery};
    const LimitArguments own{time, passes, error};
    return rendered(self, [&](PythonSession& s) {
        s.run(own.limits().any() ? own.limits() : s.limits(), progress, files.files());
    });
}

py::object next(const py::object& self) {
    bool isPass = false;
    py::object image = rendered(self, [&](PythonSession& s) { isPass = s.next(); });
    if (!isPass) throw py::stop_iteration();
    return image;
}

std::optional<double> known(double value, bool isKnown) {
    return isKnown ? std::optional<double>(value) : std::nullopt;
}

void defineProgress(py::module_& module) {
    py::class_<Progress> type(module, "Progress", "What is known after a pass.");
    type.attr("__module__") = "metrolux";
    type.def_readonly("passes", &Progress::passes, "rendered so far")
        .def_readonly("seconds", &Progress::seconds, "of rendering")
        .def_readonly(
            "relative_error", &Progress::relativeError,
            "estimated root of the mean squared relative error of the image; inf before it is known")
        .def_property_readonly(
            "seconds_remaining",
            [](const Progress& p) { return known(p.secondsRemaining, p.secondsRemaining >= 0); },
            "until a limit is reached, an estimate; None when unknown")
        .def_readonly("rays_per_second", &Progress::raysPerSecond, "traced so far")
        .def_readonly("note", &Progress::note, "of the integrator, for people")
        .def("__repr__", [](const Progress& p) {
            char text[120];
            std::snprintf(text, sizeof text, "<metrolux.Progress pass %u, %.2f s, error %.4g>", p.passes,
                          p.seconds, p.relativeError);
            return std::string(text);
        });
}

}  // namespace

void rethrowWithImage(py::error_already_set& problem, const py::object& image) {
    if (problem.matches(PyExc_KeyboardInterrupt)) {
        const py::object type = py::module_::import("metrolux").attr("Interrupted");
        PyErr_SetObject(type.ptr(), type(image).ptr());
        throw py::error_already_set();
    }
    if (PyObject_SetAttrString(problem.value().ptr(), "image", image.ptr()) != 0) PyErr_Clear();
    throw;
}

void defineSession(py::module_& module) {
    defineProgress(module);
    py::class_<PythonSession, Handle> type(module, "Session",
                                           R"(A rendering in progress; Scene.session() makes one.

Iterating renders pass by pass and yields the image after each: `for image in session`. It ends at a limit that
the session was made with, or after stop(). image, layers and variance are views of buffers that the session has:
they are brought up to date when they are asked for and by rendering, and are read-only; image.copy() keeps one.

Several threads may hold a session. While one renders, which it does without the interpreter's lock, the others
may call stop() only.)");
    type.attr("__module__") = "metrolux";
    type.def("__iter__", [](const py::object& self) { return self; })
        .def("__next__", &next)
        .def(
            "step", [](const py::object& self) { return rendered(self, [](PythonSession& s) { s.step(); }); },
            "Renders one pass, whatever the limits are. The image, float32 (height, width, 3).")
        .def("render", &render, py::kw_only(), py::arg("time") = py::none(), py::arg("passes") = py::none(),
             py::arg("error") = py::none(), py::arg("progress") = py::none(), py::arg("output") = py::none(),
             py::arg("overwrite") = false, py::arg("exposure") = 0.0, py::arg("curve") = "srgb",
             py::arg("save_every") = kDefaultSaveEvery, py::arg("checkpoint") = py::none(),
             py::arg("checkpoint_every") = kDefaultCheckpointEvery,
             R"(Renders until a limit is reached; the image, float32 (height, width, 3), linear Rec.709.

Limits, of which the first that is reached counts, and which count earlier runs too: time in seconds, passes, error
(estimated relative error of the image). Without any, those of the session; without these, a minute. progress,
output, checkpoint and the rest are as in Scene.render(). Ctrl-C ends the pass in progress and raises Interrupted.)")
        .def(
            "stop", [](PythonSession& s) { s.requestStop(); },
            "Ends the rendering in progress after its pass, or the next one before its first. From any "
            "thread.")
        .def_property_readonly("image", &imageIn,
                               "float32 (height, width, 3), linear Rec.709; black without a pass")
        .def_property_readonly(
            "variance",
            [](const py::object& self) {
                return viewOf(of(self).use([](Session& s) { return s.variance(); }), self);
            },
            R"(float32 (height, width, 1): variance of the mean of each pixel's luminance.

Too small where passes are correlated, as those of Markov chains are.)")
        .def_property_readonly(
            "layers", &layersIn,
            "the session's layers by name, float32 (height, width, channels)")
        .def_property_readonly(
            "progress", [](PythonSession& s) { return s.use([](Session& own) { return own.progress(); }); },
            "a Progress")
        .def_property_readonly(
            "statistics",
            [](PythonSession& s) { return fromJson(s.use([](Session& own) { return own.statistics(); })); },
            "what `metrolux render --stats` writes, a dict")
        .def_property_readonly(
            "scene", [](PythonSession& s) { return s.use([](Session& own) { return own.scene(); }); },
            "the Scene")
        .def_property_readonly(
            "integrator",
            [](PythonSession& s) { return s.use([](Session& own) { return own.integrator(); }); }, "its name")
        .def_property_readonly(
            "threads", [](PythonSession& s) { return s.use([](Session& own) { return own.threads(); }); },
            "how many render")
        .def(
            "save",
            [](PythonSession& s, const std::filesystem::path& file) {
                s.use([&](Session& own) { own.save(file); });
            },
            py::arg("checkpoint"), "Writes the whole state to a file, for resume().")
        .def(
            "resume",
            [](PythonSession& s, const std::filesystem::path& file) {
                s.use([&](Session& own) { own.resume(file); });
            },
            py::arg("checkpoint"),
            "Before the first pass: goes on from a checkpoint of the same scene and options, bit for bit.")
        .def(
            "save_image",
            [](PythonSession& s, const std::filesystem::path& file, double exposure,
               const std::string& curve) {
                s.use([&](Session& own) { own.saveImage(file, {exposure, curve}); });
            },
            py::arg("file"), py::kw_only(), py::arg("exposure") = 0.0, py::arg("curve") = "srgb",
            "Writes .exr with layers and metadata, or .png through exposure (stops) and curve (srgb or "
            "filmic).")
        .def("__repr__", [](PythonSession& s) {
            return s.use([](Session& own) {
                return "<metrolux.Session " + own.integrator() + " of " + own.scene().source() + ", " +
                       std::to_string(own.progress().passes) + " passes>";
            });
        });
}

}  // namespace metrolux::python
