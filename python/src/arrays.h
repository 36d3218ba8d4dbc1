#pragma once
/// Pixels and numbers between numpy and the library.

#include <metrolux/image.h>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace metrolux::python {

namespace py = pybind11;

/// A metrolux.Image of pixels that `owner` keeps; read-only, nothing is copied.
py::object viewOf(const ImageView& pixels, const py::object& owner);
/// A metrolux.Image that owns the pixels, which are moved into it.
py::object imageOf(Image pixels);
/// Float pixels of an array (height, width[, channels]), converted only if they are of another type or order.
/// `what` names it in errors. The view is valid as long as the object lives.
class Pixels {
  public:
    Pixels(const py::handle& array, const char* what);
    const ImageView& view() const { return view_; }

  private:
    py::array_t<float, py::array::c_style | py::array::forcecast> array_;
    ImageView view_;
};

/// "(4, 3)".
std::string shapeOf(const py::array& array);
/// What json.loads makes of it.
py::object fromJson(const std::string& text);

}  // namespace metrolux::python
