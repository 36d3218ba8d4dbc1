#pragma once
#include "base/math.h"

#include <Imath/ImathMatrix.h>

namespace metrolux::core {

using Vec3d = Imath::V3d;

/// Affine or projective map of 3D points, column-vector convention as in Mitsuba: p' = M p, and
/// (a * b)(p) = a(b(p)). Kept in double precision with its inverse. A map may be singular: it flattens space,
/// and has no inverse.
class Transform {
  public:
    Transform();  ///< identity
    /// Rows of the matrix; throws Error when an element is not finite.
    static Transform fromRows(const double (&rows)[4][4]);
    /// What another Transform said of itself and of its inverse: the same bits.
    static Transform fromRows(const double (&rows)[4][4], const double (&inverse)[4][4]);
    /// Positions keep double precision where single precision would be felt: see settled().
    static Transform translate(const Vec3d& offset);
    static Transform scale(const Vec3f& factors);
    /// Rotation by `degrees` around `axis` (right-hand rule); throws Error for a zero axis, unless there is
    /// nothing to rotate by.
    static Transform rotate(const Vec3f& axis, double degrees);
    /// Camera-to-world map with +z toward target and +x to the left of the image (Mitsuba's convention).
    static Transform lookAt(const Vec3d& origin, const Vec3d& target, const Vec3f& up);

    Transform operator*(const Transform& other) const;
    Transform inverse() const;  ///< throws Error when singular
    bool isSingular() const { return singular_; }

    Vec3f point(const Vec3f& p) const;
    Vec3d exactPoint(const Vec3d& p) const;  ///< not rounded
    Vec3f vector(const Vec3f& v) const;
    /// Transforms by the inverse transpose; the result is not normalized. A singular map takes the matrix of
    /// cofactors in its place: the normal of the plane onto which it flattens, or zero where that has none.
    Vec3f normal(const Vec3f& n) const;

    double at(int row, int column) const { return m_[row][column]; }
    double determinant3() const;  ///< of the upper-left 3x3 block; negative when handedness flips
    bool isIdentity() const;
    bool hasScale() const;  ///< true when some axis changes its length by more than 1e-3 (relative)

  private:
    double m_[4][4];
    double inv_[4][4];  ///< of a singular map the adjugate of the upper-left 3x3 block
    bool singular_ = false;
};

/// A position as scenes keep it. Up to 4096 it has single precision, which is that of points; what lies
/// further out keeps all digits, as the scene may be moved to the origin (io/mitsuba/world_origin.h).
Vec3d settled(const Vec3d& position);

}  // namespace metrolux::core
