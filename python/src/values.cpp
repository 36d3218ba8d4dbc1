#include "values.h"

#include "arrays.h"

#include <metrolux/error.h>

namespace metrolux::python {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::string typeName(const py::handle& value) { return Py_TYPE(value.ptr())->tp_name; }

[[noreturn]] void fail(const std::string& path, const std::string& problem) {
    throw Error("scene:" + path + ": " + problem);
}

/// A dictionary may contain itself.
struct Nesting {
    Nesting() {
        if (Py_EnterRecursiveCall(" in the objects of a scene")) throw py::error_already_set();
    }
    ~Nesting() { Py_LeaveRecursiveCall(); }
    Nesting(const Nesting&) = delete;
    Nesting& operator=(const Nesting&) = delete;
};

/// The numbers of an array or of sequences; nothing for what has none.
std::optional<Doubles> numbersFrom(const py::handle& value) {
    if (py::isinstance<py::str>(value) ||
        !(PySequence_Check(value.ptr()) || py::isinstance<py::array>(value)))
        return std::nullopt;
    Doubles array = Doubles::ensure(value);
    if (array) return array;
    PyErr_Clear();
    return std::nullopt;
}

Transform matrixFrom(const Doubles& array) {
    std::array<double, 16> rows;
    std::copy_n(array.data(), 16, rows.begin());
    return Transform::matrix(rows);
}

/// Of the plane, as those of `to_uv` may be.
Transform planeMatrixFrom(const Doubles& array) {
    const double* m = array.data();
    return Transform::matrix({m[0], m[1], 0, m[2], m[3], m[4], 0, m[5], 0, 0, 1, 0, m[6], m[7], 0, m[8]});
}

Spectrum spectrumFrom(const Doubles& array) {
    Spectrum result;
    for (py::ssize_t i = 0; i < array.shape(0); ++i) {
        result.wavelengths.push_back(array.at(i, 0));
        result.values.push_back(array.at(i, 1));
    }
    return result;
}

/// Pixels of a bitmap.
Image pixelsFrom(const Doubles& array) {
    return {{array.data(), array.data() + array.size()},
            static_cast<int>(array.shape(0)),
            static_cast<int>(array.shape(1)),
            static_cast<int>(array.shape(2))};
}

Value arrayFrom(const Doubles& array, const std::string& path) {
    const auto is = [&](py::ssize_t rows, py::ssize_t columns) {
        return array.ndim() == 2 && (rows < 0 || array.shape(0) == rows) && array.shape(1) == columns;
    };
    if (array.ndim() == 1 && array.shape(0) == 3) return Vector{array.at(0), array.at(1), array.at(2)};
    if (is(4, 4)) return matrixFrom(array);
    if (is(3, 3)) return planeMatrixFrom(array);
    if (is(-1, 2)) return spectrumFrom(array);
    if (array.ndim() == 3) return pixelsFrom(array);
    fail(path, "found an array of shape " + shapeOf(array) +
                   ", expected (3,) for a point, a vector or a color, (4, 4) for a transform, (n, 2) for "
                   "wavelengths and values, or (height, width, channels) for pixels");
}

py::object vectorArray(double x, double y, double z) {
    py::array_t<double> array(3);
    array.mutable_at(0) = x;
    array.mutable_at(1) = y;
    array.mutable_at(2) = z;
    return array;
}

py::object spectrumDict(const Spectrum& s) {
    if (s.wavelengths.empty())
        return py::dict(py::arg("type") = "spectrum", py::arg("value") = s.values.at(0));
    py::array_t<double> array({static_cast<py::ssize_t>(s.values.size()), py::ssize_t{2}});
    for (size_t i = 0; i < s.values.size(); ++i) {
        array.mutable_at(i, 0) = s.wavelengths[i];
        array.mutable_at(i, 1) = s.values[i];
    }
    return py::dict(py::arg("type") = "spectrum", py::arg("value") = array);
}

}  // namespace

std::optional<Number> numberFrom(const py::handle& value) {
    if (PyBool_Check(value.ptr())) return Number(value.cast<bool>());
    if (PyFloat_Check(value.ptr())) return Number(value.cast<double>());
    if (PyLong_Check(value.ptr())) {
        const long long number = PyLong_AsLongLong(value.ptr());
        if (number == -1 && PyErr_Occurred()) throw py::error_already_set();
        return Number(std::int64_t{number});
    }
    // numpy's scalars, and its arrays without dimensions, which item() makes Python's
    if (!py::hasattr(value, "dtype") || !py::hasattr(value, "item")) return std::nullopt;
    if (value.attr("ndim").cast<int>() != 0) return std::nullopt;
    const py::object item = value.attr("item")();
    return PyBool_Check(item.ptr()) || PyFloat_Check(item.ptr()) || PyLong_Check(item.ptr())
               ? numberFrom(item)
               : std::nullopt;
}

Transform transformFrom(const py::handle& value, const std::string& what) {
    if (py::isinstance<Transform>(value)) return value.cast<Transform>();
    const std::optional<Doubles> numbers = numbersFrom(value);
    if (numbers && numbers->ndim() == 2 && numbers->shape(0) == 4 && numbers->shape(1) == 4)
        return matrixFrom(*numbers);
    throw Error(what + ": found " + (numbers ? "an array of shape " + shapeOf(*numbers) : typeName(value)) +
                ", expected a Transform or an array (4, 4)");
}

Object objectFrom(const py::dict& dict, const std::string& path) {
    const Nesting nesting;
    if (!dict.contains("type") || !py::isinstance<py::str>(dict["type"]))
        fail(path, "found a dictionary without a string \"type\", expected one");
    Object object(dict["type"].cast<std::string>());
    for (const auto& [key, value] : dict) {
        if (!py::isinstance<py::str>(key))
            fail(path, "found the key " + py::repr(key).cast<std::string>() + ", expected a string");
        const auto name = key.cast<std::string>();
        if (name == "type") continue;
        object.set(name, valueFrom(value, path.empty() ? name : path + "." + name));
    }
    return object;
}

Value valueFrom(const py::handle& value, const std::string& path) {
    if (py::isinstance<py::dict>(value)) return objectFrom(value.cast<py::dict>(), path);
    if (py::isinstance<py::str>(value)) return value.cast<std::string>();
    if (py::isinstance<Transform>(value)) return value.cast<Transform>();
    if (py::isinstance<Mesh>(value)) return std::shared_ptr<const Mesh>(value.cast<std::shared_ptr<Mesh>>());
    if (const std::optional<Number> number = numberFrom(value))
        return std::visit([](auto n) { return Value(n); }, *number);
    if (py::hasattr(value, "__fspath__")) return value.attr("__fspath__")().cast<std::string>();
    if (const std::optional<Doubles> numbers = numbersFrom(value)) return arrayFrom(*numbers, path);
    fail(path, "found " + typeName(value) +
                   ", expected a number, a string, an array, a Transform, a Mesh or a dictionary");
}

py::object toPython(const Value& value) {
    struct Convert {
        py::object operator()(bool v) const { return py::bool_(v); }
        py::object operator()(std::int64_t v) const { return py::int_(v); }
        py::object operator()(double v) const { return py::float_(v); }
        py::object operator()(const std::string& v) const { return py::str(v); }
        py::object operator()(const Vector& v) const { return vectorArray(v.x, v.y, v.z); }
        py::object operator()(const Color& c) const { return vectorArray(c.r, c.g, c.b); }
        py::object operator()(const Spectrum& s) const { return spectrumDict(s); }
        py::object operator()(const Blackbody& b) const {
            return py::dict(py::arg("type") = "blackbody", py::arg("temperature") = b.kelvin,
                            py::arg("scale") = b.scale);
        }
        py::object operator()(const Transform& t) const { return py::cast(t); }
        py::object operator()(const Reference& r) const {
            return py::dict(py::arg("type") = "ref", py::arg("id") = r.id);
        }
        py::object operator()(const std::shared_ptr<const Object>& object) const {
            py::dict dict(py::arg("type") = object->type());
            for (const auto& [name, child] : object->values()) dict[py::str(name)] = toPython(child);
            return dict;
        }
        py::object operator()(const std::shared_ptr<const Mesh>& mesh) const {
            return py::cast(std::const_pointer_cast<Mesh>(mesh));  // its arrays are read-only in Python
        }
        py::object operator()(const std::shared_ptr<const Image>& image) const {
            auto kept = std::make_unique<std::shared_ptr<const Image>>(image);
            const py::capsule owner(kept.get(),
                                    [](void* p) { delete static_cast<std::shared_ptr<const Image>*>(p); });
            kept.release();  // the capsule's by now
            return viewOf(image->view(), owner);
        }
    };
    return std::visit(Convert{}, value.data());
}

}  // namespace metrolux::python
