#include "base/transform.h"

#include "base/error.h"

namespace metrolux::core {

namespace {

using Matrix = double[4][4];

void setIdentity(Matrix& m) {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) m[i][j] = i == j ? 1.0 : 0.0;
}

void multiply(const Matrix& a, const Matrix& b, Matrix& out) {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += a[i][k] * b[k][j];
            out[i][j] = sum;
        }
}

/// Gauss-Jordan with full row pivoting on a row-equilibrated copy; false when singular.
bool invert(const Matrix& m, Matrix& out) {
    Matrix a;
    setIdentity(out);
    for (int i = 0; i < 4; ++i) {
        double largest = 0;
        for (int j = 0; j < 4; ++j) largest = std::max(largest, std::abs(m[i][j]));
        if (!(largest > 0)) return false;
        for (int j = 0; j < 4; ++j) {
            a[i][j] = m[i][j] / largest;
            out[i][j] /= largest;
        }
    }
    for (int column = 0; column < 4; ++column) {
        int pivot = column;
        for (int i = column + 1; i < 4; ++i)
            if (std::abs(a[i][column]) > std::abs(a[pivot][column])) pivot = i;
        if (!(std::abs(a[pivot][column]) > 1e-30)) return false;
        for (int j = 0; j < 4; ++j) {
            std::swap(a[column][j], a[pivot][j]);
            std::swap(out[column][j], out[pivot][j]);
        }
        const double scale = 1.0 / a[column][column];
        for (int j = 0; j < 4; ++j) {
            a[column][j] *= scale;
            out[column][j] *= scale;
        }
        for (int i = 0; i < 4; ++i) {
            const double factor = i == column ? 0.0 : a[i][column];
            if (factor == 0.0) continue;
            for (int j = 0; j < 4; ++j) {
                a[i][j] -= factor * a[column][j];
                out[i][j] -= factor * out[column][j];
            }
        }
    }
    return true;
}

/// The transposed cofactors of the upper-left 3x3 block.
void adjugate3(const Matrix& m, Matrix& out) {
    setIdentity(out);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            out[j][i] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
}

}  // namespace

Transform::Transform() {
    setIdentity(m_);
    setIdentity(inv_);
}

Transform Transform::fromRows(const double (&rows)[4][4]) {
    Transform result;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            if (!std::isfinite(rows[i][j])) throw Error("transform matrix has an element that is not finite");
            result.m_[i][j] = rows[i][j];
        }
    result.singular_ = !invert(result.m_, result.inv_);
    if (result.singular_) adjugate3(result.m_, result.inv_);
    return result;
}

Transform Transform::fromRows(const double (&rows)[4][4], const double (&inverse)[4][4]) {
    Transform t;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            t.m_[i][j] = rows[i][j];
            t.inv_[i][j] = inverse[i][j];
        }
    return t;
}

Vec3d settled(const Vec3d& position) {
    Vec3d result = position;
    for (int i = 0; i < 3; ++i)
        if (std::abs(position[i]) <= 4096) result[i] = static_cast<float>(position[i]);
    return result;
}

Transform Transform::translate(const Vec3d& offset) {
    const Vec3d o = settled(offset);
    const double rows[4][4] = {{1, 0, 0, o.x}, {0, 1, 0, o.y}, {0, 0, 1, o.z}, {0, 0, 0, 1}};
    return fromRows(rows);
}

Transform Transform::scale(const Vec3f& factors) {
    const double rows[4][4] = {
        {factors.x, 0, 0, 0}, {0, factors.y, 0, 0}, {0, 0, factors.z, 0}, {0, 0, 0, 1}};
    return fromRows(rows);
}

Transform Transform::rotate(const Vec3f& axis, double degrees) {
    const double length =
        std::sqrt(double(axis.x) * axis.x + double(axis.y) * axis.y + double(axis.z) * axis.z);
    if (degrees == 0 && length == 0) return {};
    if (!(length > 0)) throw Error("rotation around an axis of zero length");
    const double x = axis.x / length, y = axis.y / length, z = axis.z / length;
    const double angle = degrees * (std::numbers::pi / 180.0);
    const double c = std::cos(angle), s = std::sin(angle), d = 1.0 - c;
    const double rows[4][4] = {{x * x * d + c, x * y * d - z * s, x * z * d + y * s, 0},
                               {y * x * d + z * s, y * y * d + c, y * z * d - x * s, 0},
                               {z * x * d - y * s, z * y * d + x * s, z * z * d + c, 0},
                               {0, 0, 0, 1}};
    return fromRows(rows);
}

Transform Transform::lookAt(const Vec3d& origin, const Vec3d& target, const Vec3f& up) {
    const Vec3d o = settled(origin), direction = (settled(target) - o).normalized();
    const Vec3d left = Vec3d(up).normalized().cross(direction).normalized();
    if (direction.length() < 0.5 || left.length() < 0.5)
        throw Error("lookat: origin and target coincide, or up is parallel to the viewing direction");
    const Vec3d newUp = direction.cross(left);
    const double rows[4][4] = {{left.x, newUp.x, direction.x, o.x},
                               {left.y, newUp.y, direction.y, o.y},
                               {left.z, newUp.z, direction.z, o.z},
                               {0, 0, 0, 1}};
    return fromRows(rows);
}

Transform Transform::operator*(const Transform& other) const {
    Transform result;
    multiply(m_, other.m_, result.m_);
    result.singular_ = singular_ || other.singular_;
    if (result.singular_)
        adjugate3(result.m_, result.inv_);
    else
        multiply(other.inv_, inv_, result.inv_);
    return result;
}

Transform Transform::inverse() const {
    if (singular_) throw Error("transform matrix is singular");
    Transform result;
    std::copy(&inv_[0][0], &inv_[0][0] + 16, &result.m_[0][0]);
    std::copy(&m_[0][0], &m_[0][0] + 16, &result.inv_[0][0]);
    return result;
}

Vec3f Transform::point(const Vec3f& p) const {
    double r[4];
    for (int i = 0; i < 4; ++i) r[i] = m_[i][0] * p.x + m_[i][1] * p.y + m_[i][2] * p.z + m_[i][3];
    const double w = r[3] == 1.0 ? 1.0 : 1.0 / r[3];
    return {float(r[0] * w), float(r[1] * w), float(r[2] * w)};
}

Vec3d Transform::exactPoint(const Vec3d& p) const {
    double r[4];
    for (int i = 0; i < 4; ++i) r[i] = m_[i][0] * p.x + m_[i][1] * p.y + m_[i][2] * p.z + m_[i][3];
    const double w = r[3] == 1.0 ? 1.0 : 1.0 / r[3];
    return {r[0] * w, r[1] * w, r[2] * w};
}

Vec3f Transform::vector(const Vec3f& v) const {
    double r[3];
    for (int i = 0; i < 3; ++i) r[i] = m_[i][0] * v.x + m_[i][1] * v.y + m_[i][2] * v.z;
    return {float(r[0]), float(r[1]), float(r[2])};
}

Vec3f Transform::normal(const Vec3f& n) const {
    double r[3];
    for (int i = 0; i < 3; ++i) r[i] = inv_[0][i] * n.x + inv_[1][i] * n.y + inv_[2][i] * n.z;
    return {float(r[0]), float(r[1]), float(r[2])};
}

double Transform::determinant3() const {
    return m_[0][0] * (m_[1][1] * m_[2][2] - m_[1][2] * m_[2][1]) -
           m_[0][1] * (m_[1][0] * m_[2][2] - m_[1][2] * m_[2][0]) +
           m_[0][2] * (m_[1][0] * m_[2][1] - m_[1][1] * m_[2][0]);
}

bool Transform::isIdentity() const {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            if (m_[i][j] != (i == j ? 1.0 : 0.0)) return false;
    return true;
}

bool Transform::hasScale() const {
    for (int j = 0; j < 3; ++j) {
        const double length2 = m_[0][j] * m_[0][j] + m_[1][j] * m_[1][j] + m_[2][j] * m_[2][j];
        if (std::abs(length2 - 1.0) > 2e-3) return true;
    }
    return false;
}

}  // namespace metrolux::core
