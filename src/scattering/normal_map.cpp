#include "scattering/normal_map.h"

namespace metrolux::core {
namespace {

class NormalMap final : public PerturbedBsdf {
  public:
    explicit NormalMap(const NormalMapParameters& p)
        : PerturbedBsdf(p.nested, p.options), normals_(p.normals) {}

  protected:
    Vec3f normal(const SurfaceInteraction& si) const override {
        const Rgb c = normals_->rgb(si);
        return {2 * c.x - 1, 2 * c.y - 1, 2 * c.z - 1};
    }

  private:
    TexturePtr normals_;
};

}  // namespace

BsdfPtr makeNormalMap(const NormalMapParameters& parameters) {
    return std::make_shared<NormalMap>(parameters);
}

}  // namespace metrolux::core
