/// The extension module: everything of the package but the class Image.

#include "image.h"
#include "scene.h"
#include "session.h"
#include "unlocked.h"
#include "values.h"

#include <metrolux/error.h>
#include <metrolux/log.h>
#include <metrolux/version.h>

namespace metrolux::python {
namespace {

/// To the logger "metrolux" of Python's logging, which prints warnings unless it is told otherwise. The
/// library calls it one at a time: nothing that may log is called with the interpreter's lock, for which this
/// waits.
void logToPython(LogLevel level, const std::string& message) {
    const py::gil_scoped_acquire acquire;
    try {
        const py::object logger = py::module_::import("logging").attr("getLogger")("metrolux");
        logger.attr(level == LogLevel::Warning ? "warning" : "info")("%s", message);
    } catch (py::error_already_set& problem) {
        problem.discard_as_unraisable("metrolux: a handler of logging");
    }
}

}  // namespace

PYBIND11_MODULE(_metrolux, module) {
    module.attr("__version__") = version();
    const py::object error = py::register_exception<Error>(module, "Error", PyExc_RuntimeError);
    error.attr("__module__") = "metrolux";
    error.attr("__doc__") =
        "Something that was given cannot be used; the text is the command's. Where a rendering could not be\n"
        "written to its files, `image` is what was rendered.";
    defineImages(module);
    defineObjects(module);
    defineScene(module);
    defineSession(module);
    defineIntegrators(module);
    setLog(logToPython);
    py::module_::import("atexit").attr("register")(py::cpp_function([] {
        stopSessions();
        finishUnlockedWork();
        setLog({});
    }));
}

}  // namespace metrolux::python
