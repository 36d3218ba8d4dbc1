/// What renders, and parts that are joined.

#include "arrays.h"
#include "scene.h"
#include "session.h"

#include <metrolux/error.h>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace metrolux::python {
namespace {

py::dict byName() {
    py::dict result;
    for (IntegratorDescription& integrator : integrators()) {
        const py::str name(integrator.name);
        result[name] = std::move(integrator);
    }
    return result;
}

py::dict mergeParts(const std::vector<std::filesystem::path>& parts, const py::object& output, bool overwrite,
                    double exposure, const std::string& curve, const std::vector<std::string>& layers) {
    FileArguments arguments{output, overwrite, exposure, curve, 0, std::nullopt, 0};
    const Files files = arguments.files();
    const Merged merged = [&] {
        const Unlocked unlocked;
        return merge(parts, files, layers);
    }();
    for (const std::string& failure : merged.outcome.failures) throw Error(failure);
    return fromJson(merged.statistics);
}

}  // namespace

void defineIntegrators(py::module_& module) {
    using P = ParameterDescription;
    py::class_<P> parameter(module, "Parameter", "A keyword of an integrator.");
    parameter.attr("__module__") = "metrolux";
    parameter.def_readonly("name", &P::name, "the keyword")
        .def_readonly("help", &P::help, "what it is")
        .def_readonly("default", &P::defaultValue, "a bool, a number or a string")
        .def_readonly("default_text", &P::defaultText, "the default for people: \"0: from the pixel size\"")
        .def_readonly("expected", &P::expected, "\"a number from 0 to 1\"")
        .def_readonly("choices", &P::choices, "all values, where it is one of a few")
        .def("__repr__", [](const P& p) {
            return "<metrolux.Parameter " + p.name + "=" + p.defaultText + ": " + p.expected + ">";
        });

    using I = IntegratorDescription;
    py::class_<I> integrator(module, "Integrator", "An algorithm that renders.");
    integrator.attr("__module__") = "metrolux";
    integrator.def_readonly("name", &I::name, "for Scene.render()")
        .def_readonly("summary", &I::summary, "what it is")
        .def_property_readonly(
            "parameters",
            [](const I& i) {
                py::dict result;
                for (const P& p : i.parameters) result[py::str(p.name)] = p;
                return result;
            },
            "its Parameters by name")
        .def("__repr__",
             [](const I& i) { return "<metrolux.Integrator " + i.name + ": " + i.summary + ">"; });

    module.def("integrators", &byName, "All Integrators by name; the first is the default.");
    module.def("merge", &mergeParts, py::arg("parts"), py::arg("output"), py::kw_only(),
               py::arg("overwrite") = false, py::arg("exposure") = 0.0, py::arg("curve") = "srgb",
               py::arg("layers") = py::tuple(), R"(Joins checkpoints of slices that were rendered apart.

Writes the image, to the bit that of one process which renders them all; output, overwrite, exposure and curve as in
Scene.render(), layers: none or ["variance"]. The statistics, a dict.)");
}

}  // namespace metrolux::python
