#include "api/internals.h"

namespace metrolux {
namespace {

using Rows = double[4][4];

void unpack(const std::array<double, 16>& from, Rows& to) {
    for (size_t i = 0; i < 16; ++i) to[i / 4][i % 4] = from[i];
}

core::Vec3f vec3(const Vector& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

core::Vec3d position(const Vector& v) { return {v.x, v.y, v.z}; }

}  // namespace

core::Transform Internals::transform(const Transform& t) {
    Rows rows, inverse;
    unpack(t.rows_, rows);
    unpack(t.inverse_, inverse);
    return core::Transform::fromRows(rows, inverse);
}

Transform Internals::transform(const core::Transform& t) {
    Transform result;
    const core::Transform inverse = t.inverse();
    for (int i = 0; i < 16; ++i) {
        result.rows_[static_cast<size_t>(i)] = t.at(i / 4, i % 4);
        result.inverse_[static_cast<size_t>(i)] = inverse.at(i / 4, i % 4);
    }
    return result;
}

Transform::Transform() : rows_{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, inverse_(rows_) {}

Transform Transform::matrix(const std::array<double, 16>& values) {
    Rows rows;
    unpack(values, rows);
    return Internals::transform(core::Transform::fromRows(rows));
}

Transform Transform::translate(const Vector& offset) {
    return Internals::transform(core::Transform::translate(position(offset)));
}

Transform Transform::scale(const Vector& factors) {
    return Internals::transform(core::Transform::scale(vec3(factors)));
}

Transform Transform::rotate(const Vector& axis, double degrees) {
    return Internals::transform(core::Transform::rotate(vec3(axis), degrees));
}

Transform Transform::lookAt(const Vector& origin, const Vector& target, const Vector& up) {
    return Internals::transform(core::Transform::lookAt(position(origin), position(target), vec3(up)));
}

Transform Transform::operator*(const Transform& other) const {
    return Internals::transform(Internals::transform(*this) * Internals::transform(other));
}

Object& Object::set(const std::string& name, Value value) {
    for (auto& [key, old] : values_) {
        if (key != name) continue;
        old = std::move(value);
        return *this;
    }
    values_.emplace_back(name, std::move(value));
    return *this;
}

const Value* Object::find(const std::string& name) const {
    for (const auto& [key, value] : values_)
        if (key == name) return &value;
    return nullptr;
}

}  // namespace metrolux
