#include "scattering/diffuse.h"

#include "scattering/cosine_sampled.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class Diffuse {
  public:
    explicit Diffuse(const DiffuseParameters& parameters) : reflectance_(parameters.reflectance, 0.5f) {}

    Rgb albedo(const SurfaceInteraction& si) const { return clampUnit(reflectance_(si)); }
    Rgb radiance(const SurfaceInteraction& si, const Vec3f&, const Vec3f&) const { return albedo(si); }

  private:
    ColorParameter reflectance_;
};

}  // namespace

BsdfPtr makeDiffuse(const DiffuseParameters& parameters) {
    return std::make_shared<CosineSampled<Diffuse>>(Diffuse(parameters));
}

}  // namespace metrolux::core
