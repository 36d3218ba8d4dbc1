#pragma once
#include "base/frame.h"
#include "base/warp.h"
#include "endpoint/light.h"
#include "endpoint/lights/emission.h"

namespace metrolux::core {

/// What infinitely far lights share: rays that enter the scene through a disk of the bounding sphere's
/// radius.
class InfiniteLight : public Light {
  public:
    bool isInfinite() const override { return true; }
    void setSceneBounds(const SceneBounds& bounds) override { bounds_ = bounds; }
    LightPtr copy() const override = 0;

  protected:
    float diskArea() const { return kPi * sqr(bounds_.radius); }
    float diskPdf() const { return 1.0f / diskArea(); }

    /// Origin of a ray in direction `w`, uniform on the disk before the scene.
    Vec3f diskPoint(const Vec3f& w, const Vec2f& u) const {
        const Frame frame = Frame::fromNormal(w);
        const Vec2f d = warp::squareToDisk(u) * bounds_.radius;
        return bounds_.center + frame.s * d.x + frame.t * d.y - w * bounds_.radius;
    }

    /// A connection along unit `wi`; value and pdf of direction are the caller's.
    EndpointConnection connectionAlong(const Vec3f& x, const Vec3f& wi) const {
        EndpointConnection c;
        c.wi = wi;
        c.distance = 2 * bounds_.radius;
        c.point = x + wi * c.distance;
        c.pdfPosition = diskPdf();
        return c;
    }

    SceneBounds bounds_;
};

}  // namespace metrolux::core
