#include "scattering/bump_map.h"

#include "geometry/shape.h"

namespace metrolux::core {
namespace {

class BumpMap final : public PerturbedBsdf {
  public:
    explicit BumpMap(const BumpMapParameters& p)
        : PerturbedBsdf(p.nested, p.options), height_(p.height), scale_(p.scale) {}

  protected:
    /// Normal of p + h n; the derivative of n is left out, as usual [Blinn 1978].
    Vec3f normal(const SurfaceInteraction& si) const override {
        const Vec2f gradient = height_->gradient(si) * scale_;
        const auto displaced = [&](const Vec3f& dp, float slope) {
            return dp + si.ns * (slope - dot(si.ns, dp));
        };
        const Partials p = partials(si);
        Vec3f n = cross(displaced(p.dpdu, gradient.x), displaced(p.dpdv, gradient.y));
        if (dot(n, si.ng) < 0) n = -n;
        return si.toLocal(n);
    }

  private:
    TexturePtr height_;
    float scale_;
};

}  // namespace

BsdfPtr makeBumpMap(const BumpMapParameters& parameters) { return std::make_shared<BumpMap>(parameters); }

}  // namespace metrolux::core
