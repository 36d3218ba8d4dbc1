#pragma once
/// Objects and values of scenes, between Python and the library.

#include <metrolux/object.h>

#include <optional>
#include <pybind11/pybind11.h>

namespace metrolux::python {

namespace py = pybind11;

/// A dictionary in the form of Mitsuba's load_dict. `path` is where it is in the scene, for errors.
Object objectFrom(const py::dict& dict, const std::string& path);
Value valueFrom(const py::handle& value, const std::string& path);
/// What valueFrom() takes back.
py::object toPython(const Value& value);

/// bool, int, float, numpy's scalars, or arrays of no dimensions; nothing for all else.
using Number = std::variant<bool, std::int64_t, double>;
std::optional<Number> numberFrom(const py::handle& value);

/// A Transform or an array (4, 4). `what` names it in errors.
Transform transformFrom(const py::handle& value, const std::string& what);

void defineObjects(py::module_& module);  ///< Transform and Mesh

}  // namespace metrolux::python
