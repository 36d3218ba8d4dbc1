/// Transform and Mesh.

#include "arrays.h"
#include "values.h"

#include <metrolux/error.h>

#include <cstring>
#include <pybind11/stl.h>

namespace metrolux::python {
namespace {

Vector vectorFrom(const py::handle& value, const char* what) {
    const Value made = valueFrom(value, what);
    if (const auto* vector = std::get_if<Vector>(&made.data())) return *vector;
    throw Error(std::string(what) + ": expected three numbers");
}

Transform scaled(const Transform& t, const py::handle& factors) {
    const std::optional<Number> number = numberFrom(factors);
    if (!number) return t * Transform::scale(vectorFrom(factors, "scale"));
    const double s = std::visit([](auto n) { return static_cast<double>(n); }, *number);
    return t * Transform::scale({s, s, s});
}

py::array_t<double> matrixOf(const std::array<double, 16>& rows) {
    py::array_t<double> matrix({4, 4});
    std::memcpy(matrix.mutable_data(), rows.data(), sizeof rows);
    return matrix;
}

/// Floats (count, columns) of an array, or nothing of None.
std::vector<float> columns(const py::handle& value, const std::string& name, py::ssize_t wanted) {
    if (value.is_none()) return {};
    const auto array = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(value);
    if (!array) {
        PyErr_Clear();
        throw Error(name + ": found " + Py_TYPE(value.ptr())->tp_name + ", expected an array of numbers");
    }
    if (array.ndim() != 2 || array.shape(1) != wanted)
        throw Error(name + ": found an array of shape " + shapeOf(array) + ", expected (vertices, " +
                    std::to_string(wanted) + ")");
    return {array.data(), array.data() + array.size()};
}

std::vector<std::uint32_t> trianglesOf(const py::handle& value) {
    const py::array any = py::array::ensure(value);
    const char kind = any ? any.dtype().kind() : '?';
    if (!any) PyErr_Clear();
    if ((kind != 'i' && kind != 'u') || any.ndim() != 2 || any.shape(1) != 3)
        throw Error(
            "triangles: found " +
            (any ? "an array of " + py::str(any.dtype()).cast<std::string>() + ", shape " + shapeOf(any)
                 : std::string(Py_TYPE(value.ptr())->tp_name)) +
            ", expected one of integers, (triangles, 3)");
    const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> array(any);
    std::vector<std::uint32_t> result;
    result.reserve(static_cast<size_t>(array.size()));
    for (py::ssize_t i = 0; i < array.size(); ++i) {
        const std::int64_t vertex = array.data()[i];
        if (vertex < 0 || vertex > 0xffffffffLL)
            throw Error("triangles: found the vertex " + std::to_string(vertex) + ", expected 0 or more");
        result.push_back(static_cast<std::uint32_t>(vertex));
    }
    return result;
}

Mesh::Attribute attributeOf(const std::string& name, const py::handle& value) {
    const auto array = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(value);
    if (!array) PyErr_Clear();
    const bool isGray = array && array.ndim() == 1;
    if (!isGray && !(array && array.ndim() == 2 && (array.shape(1) == 1 || array.shape(1) == 3)))
        throw Error(
            name + ": found " +
            (array ? "an array of shape " + shapeOf(array) : std::string(Py_TYPE(value.ptr())->tp_name)) +
            ", expected an array (vertices or triangles, 3), or of single values");
    return {name, isGray ? 1 : static_cast<int>(array.shape(1)), {array.data(), array.data() + array.size()}};
}

std::shared_ptr<Mesh> makeMesh(const py::handle& positions, const py::handle& triangles,
                               const py::handle& normals, const py::handle& uvs,
                               const py::kwargs& attributes) {
    auto mesh = std::make_shared<Mesh>();
    mesh->positions = columns(positions, "positions", 3);
    mesh->triangles = trianglesOf(triangles);
    mesh->normals = columns(normals, "normals", 3);
    mesh->uvs = columns(uvs, "uvs", 2);
    for (const auto& [name, values] : attributes)
        mesh->attributes.push_back(attributeOf(name.cast<std::string>(), values));
    return mesh;
}

/// A view, read-only: scenes share the mesh.
template <class T>
py::array viewOfColumns(const std::vector<T>& values, py::ssize_t columns, const py::object& owner) {
    py::array_t<T> array({static_cast<py::ssize_t>(values.size()) / columns, columns}, values.data(), owner);
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

void defineTransform(py::module_& module) {
    py::class_<Transform> type(module, "Transform", R"(An affine map of points, p' = M p, in scene units.

Begins as the identity; each method returns another Transform that applies its own part first:
Transform().translate([0, 1, 0]).rotate([0, 0, 1], 90) rotates, then translates. a @ b applies b first.)");
    type.attr("__module__") = "metrolux";
    type.def(py::init<>())
        .def(py::init([](const py::handle& matrix) { return transformFrom(matrix, "Transform"); }),
             py::arg("matrix"), "From an array (4, 4), row by row.")
        .def(
            "translate",
            [](const Transform& t, const py::handle& offset) {
                return t * Transform::translate(vectorFrom(offset, "translate"));
            },
            py::arg("offset"), "By three numbers.")
        .def("scale", &scaled, py::arg("factors"), "By a number, or by three along the axes.")
        .def(
            "rotate",
            [](const Transform& t, const py::handle& axis, double angle) {
                return t * Transform::rotate(vectorFrom(axis, "rotate"), angle);
            },
            py::arg("axis"), py::arg("angle"),
            "About an axis through the origin, in degrees, by the right-hand rule.")
        .def(
            "look_at",
            [](const Transform& t, const py::handle& origin, const py::handle& target, const py::handle& up) {
                return t * Transform::lookAt(vectorFrom(origin, "origin"), vectorFrom(target, "target"),
                                             vectorFrom(up, "up"));
            },
            py::arg("origin"), py::arg("target"), py::arg("up"),
            "From a camera's space (+z forward, +y up, +x to the left of the image) to the world.")
        .def("__matmul__", [](const Transform& a, const Transform& b) { return a * b; })
        .def_property_readonly(
            "matrix", [](const Transform& t) { return matrixOf(t.rows()); }, "float64 (4, 4), a copy.")
        .def_property_readonly(
            "inverse", [](const Transform& t) { return Transform::matrix(t.inverseRows()); },
            "The inverse map.")
        .def("__repr__", [](const Transform& t) {
            return "Transform(" + py::repr(matrixOf(t.rows()).attr("tolist")()).cast<std::string>() + ")";
        });
}

void defineMesh(py::module_& module) {
    py::class_<Mesh, std::shared_ptr<Mesh>> type(
        module, "Mesh",
        R"(Triangles in object space, for {"type": "mesh", "arrays": mesh, ...} in a scene.)");
    type.attr("__module__") = "metrolux";
    type.def(py::init(&makeMesh), py::arg("positions"), py::arg("triangles"), py::kw_only(),
             py::arg("normals") = py::none(), py::arg("uvs") = py::none(),
             R"(The arrays are copied.

positions: float (vertices, 3). triangles: integers (triangles, 3), vertices counted from 0, counterclockwise in
front. normals: float (vertices, 3); computed from the triangles if absent. uvs: float (vertices, 2).
Further names, vertex_... or face_..., are attributes for textures of the type mesh_attribute: float
(vertices or triangles, 3), or single values.)")
        .def_property_readonly(
            "positions",
            [](const py::object& self) { return viewOfColumns(self.cast<const Mesh&>().positions, 3, self); },
            "float32 (vertices, 3), read-only.")
        .def_property_readonly(
            "triangles",
            [](const py::object& self) { return viewOfColumns(self.cast<const Mesh&>().triangles, 3, self); },
            "uint32 (triangles, 3), read-only.")
        .def("__repr__", [](const Mesh& mesh) {
            return "<metrolux.Mesh of " + std::to_string(mesh.positions.size() / 3) + " vertices, " +
                   std::to_string(mesh.triangles.size() / 3) + " triangles>";
        });
}

}  // namespace

void defineObjects(py::module_& module) {
    defineTransform(module);
    defineMesh(module);
}

}  // namespace metrolux::python
