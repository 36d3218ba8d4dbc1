#pragma once
#include "base/math.h"

#include <Imath/ImathMatrix.h>

namespace metrolux::core {

/// Affine or projective map of 3D points, column-vector convention as in Mitsuba: p' = M p, and
/// (a * b)(p) = a(b(p)). Kept in double precision with its inverse.
class Transform {
  public:
    Transform();  ///< identity
    /// Rows of the matrix; throws Error when an element is not finite or the matrix is singular.
    static Transform fromRows(const double (&rows)[4][4]);
    static Transform translate(const Vec3f& offset);
    static Transform scale(const Vec3f& factors);
    /// Rotation by `degrees` around `axis` (right-hand rule); throws Error for a zero axis.
    static Transform rotate(const Vec3f& axis, double degrees);
    /// Camera-to-world map with +z toward target and +x to the left of the image (Mitsuba's convention).
    static Transform lookAt(const Vec3f& origin, const Vec3f& target, const Vec3f& up);

    Transform operator*(const Transform& other) const;
    Transform inverse() const;

    Vec3f point(const Vec3f& p) const;
    Vec3f vector(const Vec3f& v) const;
    /// Transforms by the inverse transpose; the result is not normalized.
    Vec3f normal(const Vec3f& n) const;

    double at(int row, int column) const { return m_[row][column]; }
    double determinant3() const;  ///< of the upper-left 3x3 block; negative when handedness flips
    bool isIdentity() const;
    bool hasScale() const;  ///< true when some axis changes its length by more than 1e-3 (relative)

  private:
    double m_[4][4];
    double inv_[4][4];
};

}  // namespace metrolux::core
