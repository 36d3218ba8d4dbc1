#include "arrays.h"

#include <metrolux/error.h>

namespace metrolux::python {
namespace {

/// As metrolux.Image, which is Python's: a subclass of ndarray cannot be written here.
py::object asImage(const py::array& array) {
    return array.attr("view")(py::module_::import("metrolux").attr("Image"));
}

std::vector<py::ssize_t> shape(int height, int width, int channels) { return {height, width, channels}; }

}  // namespace

py::object viewOf(const ImageView& pixels, const py::object& owner) {
    const py::array_t<float> array(shape(pixels.height, pixels.width, pixels.channels), pixels.data, owner);
    array.attr("setflags")(py::arg("write") = false);
    return asImage(array);
}

py::object imageOf(Image pixels) {
    auto kept = std::make_unique<std::vector<float>>(std::move(pixels.pixels));
    const float* data = kept->data();
    const py::capsule owner(kept.get(), [](void* p) { delete static_cast<std::vector<float>*>(p); });
    kept.release();  // the capsule's by now
    return asImage(py::array_t<float>(shape(pixels.height, pixels.width, pixels.channels), data, owner));
}

Pixels::Pixels(const py::handle& array, const char* what) {
    array_ = decltype(array_)::ensure(array);
    if (!array_) {
        PyErr_Clear();
        throw Error(std::string(what) + ": found " + Py_TYPE(array.ptr())->tp_name +
                    ", expected an array of numbers (height, width, channels)");
    }
    if (array_.ndim() != 2 && array_.ndim() != 3)
        throw Error(std::string(what) + ": found an array of shape " + shapeOf(array_) +
                    ", expected (height, width, channels) or (height, width)");
    view_ = {array_.data(), static_cast<int>(array_.shape(0)), static_cast<int>(array_.shape(1)),
             array_.ndim() == 3 ? static_cast<int>(array_.shape(2)) : 1};
}

std::string shapeOf(const py::array& array) {
    return py::str(py::object(array.attr("shape"))).cast<std::string>();
}

py::object fromJson(const std::string& text) { return py::module_::import("json").attr("loads")(text); }

}  // namespace metrolux::python
