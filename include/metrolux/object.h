#pragma once
#include <metrolux/export.h>
#include <metrolux/image.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace metrolux {

/// A point or a direction, in scene units.
struct Vector {
    double x = 0, y = 0, z = 0;
};

/// Linear Rec.709 (sRGB primaries): a reflectance in [0, 1], or an emission in radiometric units.
struct Color {
    double r = 0, g = 0, b = 0;
};

/// Values at ascending wavelengths in nanometers; a single value without wavelengths is the same at all.
struct Spectrum {
    std::vector<double> wavelengths, values;
};

/// Planck's law times `scale`.
struct Blackbody {
    double kelvin = 5000, scale = 1;
};

/// The object of this id (or, directly in the scene, of this name).
struct Reference {
    std::string id;
};

/// A map of 3D points: p' = M p, and (a * b)(p) = a(b(p)). All throw Error for a map that flattens space.
class METROLUX_API Transform {
  public:
    Transform();  ///< identity
    /// Row by row. Throws Error when an element is not finite.
    static Transform matrix(const std::array<double, 16>& rows);
    static Transform translate(const Vector& offset);
    static Transform scale(const Vector& factors);
    /// By the right-hand rule. Throws Error for a zero axis.
    static Transform rotate(const Vector& axis, double degrees);
    /// From a camera's space (+z forward, +y up, +x to the left of the image) to the world.
    static Transform lookAt(const Vector& origin, const Vector& target, const Vector& up);

    Transform operator*(const Transform& other) const;
    const std::array<double, 16>& rows() const { return rows_; }
    const std::array<double, 16>& inverseRows() const { return inverse_; }

  private:
    friend struct Internals;
    std::array<double, 16> rows_, inverse_;
};

/// Triangles in object space, for `Object("mesh", {{"arrays", mesh}})`.
struct Mesh {
    std::vector<float> positions;          ///< three numbers per vertex
    std::vector<std::uint32_t> triangles;  ///< three vertices each, counted from 0; counterclockwise in front
    std::vector<float> normals;            ///< three per vertex; empty: computed from the triangles
    std::vector<float> uvs;                ///< two per vertex, or empty
    /// Values of vertices or faces that a `mesh_attribute` texture may show.
    struct Attribute {
        std::string name;  ///< "vertex_..." or "face_..."
        int channels = 3;  ///< 1 or 3
        std::vector<float> values;
    };
    std::vector<Attribute> attributes;
};

class Object;

/// A parameter of an object: a number, a color, another object ...
class METROLUX_API Value {
  public:
    using Data = std::variant<bool, std::int64_t, double, std::string, Vector, Color, Spectrum, Blackbody,
                              Transform, Reference, std::shared_ptr<const Object>,
                              std::shared_ptr<const Mesh>, std::shared_ptr<const Image>>;

    Value(bool value) : data_(value) {}
    Value(int value) : data_(std::int64_t{value}) {}
    Value(std::int64_t value) : data_(value) {}
    Value(double value) : data_(value) {}
    Value(const char* text) : data_(std::string(text)) {}
    Value(std::string text) : data_(std::move(text)) {}
    Value(Vector value) : data_(value) {}
    Value(Color value) : data_(value) {}
    Value(Spectrum value) : data_(std::move(value)) {}
    Value(Blackbody value) : data_(value) {}
    Value(const Transform& value) : data_(value) {}
    Value(Reference value) : data_(std::move(value)) {}
    Value(Object object);
    Value(std::shared_ptr<const Object> object) : data_(std::move(object)) {}
    Value(Mesh mesh) : data_(std::make_shared<const Mesh>(std::move(mesh))) {}
    Value(std::shared_ptr<const Mesh> mesh) : data_(std::move(mesh)) {}
    /// In place of a file, for `Object("bitmap", {{"data", image}})` and an `envmap`: linear, as pixels of a
    /// floating-point file are.
    Value(Image image) : data_(std::make_shared<const Image>(std::move(image))) {}
    Value(std::shared_ptr<const Image> image) : data_(std::move(image)) {}

    const Data& data() const { return data_; }

  private:
    Data data_;
};

/// A part of a scene, as Mitsuba's load_dict has it: a plugin's type with named parameters and nested
/// objects. A string "id" names the object for a Reference. Types, parameters and defaults are those of
/// scene files.
class METROLUX_API Object {
  public:
    using Values = std::vector<std::pair<std::string, Value>>;

    explicit Object(std::string type, Values values = {})
        : type_(std::move(type)), values_(std::move(values)) {}
    /// Adds a value, or replaces the one of this name.
    Object& set(const std::string& name, Value value);

    const std::string& type() const { return type_; }
    const Values& values() const { return values_; }
    /// Null if there is none of this name.
    const Value* find(const std::string& name) const;

  private:
    std::string type_;
    Values values_;
};

inline Value::Value(Object object) : data_(std::make_shared<const Object>(std::move(object))) {}

}  // namespace metrolux
