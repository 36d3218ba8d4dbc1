#pragma once
#include <pybind11/pybind11.h>

namespace metrolux::python {

/// Scene, load, load_dict, integrators, merge.
void defineScene(pybind11::module_& module);
void defineIntegrators(pybind11::module_& module);

}  // namespace metrolux::python
