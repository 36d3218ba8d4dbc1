#pragma once
#include <pybind11/pybind11.h>

namespace metrolux::python {

/// read, write, png, compare.
void defineImages(pybind11::module_& module);

}  // namespace metrolux::python
