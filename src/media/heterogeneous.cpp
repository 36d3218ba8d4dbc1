#include "base/error.h"
#include "media/medium.h"

namespace metrolux::core {
namespace {

/// Distances at which a ray is within a box.
struct Segment {
    double begin = 0, end = 0;
};
std::optional<Segment> clip(const Imath::Box3d& box, const Vec3f& origin, const Vec3f& direction,
                            double length) {
    Segment inside{0, length};
    for (int axis = 0; axis < 3; ++axis) {
        const double o = origin[axis], d = direction[axis];
        if (d == 0) {
            if (o < box.min[axis] || o > box.max[axis]) return std::nullopt;
            continue;
        }
        const double a = (box.min[axis] - o) / d, b = (box.max[axis] - o) / d;
        inside.begin = std::max(inside.begin, std::min(a, b));
        inside.end = std::min(inside.end, std::max(a, b));
    }
    if (!(inside.begin < inside.end)) return std::nullopt;
    return inside;
}

class HeterogeneousMedium final : public Medium {
  public:
    HeterogeneousMedium(VolumePtr density, float scale, VolumePtr albedo, PhaseFunctionPtr phase)
        : Medium(std::move(phase)), density_(std::move(density)), albedo_(std::move(albedo)), scale_(scale) {
        bounds_ = density_->bounds();
        scatters_ = !isBlack(density_->maximum() * albedo_->maximum() * scale);
    }

    Rgb thickness(const Vec3f& origin, const Vec3f& direction, float length) const override {
        const auto inside = clip(bounds_, origin, direction, length);
        if (!inside) return Rgb(0.0f);
        return density_->integral(origin, direction, inside->begin, inside->end) * scale_;
    }
    std::optional<Flight> fly(const Vec3f& origin, const Vec3f& direction, float length, int channel,
                              float target) const override {
        const auto inside = clip(bounds_, origin, direction, length);
        if (!inside || !(scale_ > 0)) return std::nullopt;
        const auto crossing = density_->cross(origin, direction, inside->begin, inside->end, channel,
                                              static_cast<double>(target) / scale_);
        if (!crossing) return std::nullopt;
        return Flight{static_cast<float>(crossing->distance), crossing->integral * scale_};
    }
    Rgb extinction(const Vec3f& p) const override { return density_->value(p) * scale_; }
    Rgb scattering(const Vec3f& p) const override { return extinction(p) * albedo_->value(p); }
    bool scatters() const override { return scatters_; }

  private:
    VolumePtr density_, albedo_;
    Imath::Box3d bounds_;
    float scale_;
    bool scatters_;
};

}  // namespace

MediumPtr makeHeterogeneousMedium(VolumePtr density, float scale, VolumePtr albedo, PhaseFunctionPtr phase) {
    if (!(scale >= 0) || !std::isfinite(scale))
        throw Error("heterogeneous: the scale is {}, expected a finite number that is not negative", scale);
    for (int channel = 0; channel < 3; ++channel) {
        const float most = albedo->maximum()[channel];
        if (!(most <= 1))
            throw Error("heterogeneous: the albedo is {} in channel {}, expected values in [0, 1]", most,
                        channel);
    }
    // What is the same everywhere and has no bounds has closed forms for infinite segments.
    if (density->isConstant() && density->bounds().isInfinite() && albedo->isConstant())
        return makeHomogeneousMedium(density->maximum() * scale, albedo->maximum(), std::move(phase));
    if (!std::isfinite(maxComponent(density->maximum()) * scale))
        throw Error("heterogeneous: the extinction is {} times {}, expected a finite product",
                    maxComponent(density->maximum()), scale);
    return std::make_shared<HeterogeneousMedium>(std::move(density), scale, std::move(albedo),
                                                 std::move(phase));
}

}  // namespace metrolux::core
