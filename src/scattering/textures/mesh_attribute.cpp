#include "scattering/textures/mesh_attribute.h"

#include "geometry/shape.h"

namespace metrolux::core {
namespace {

class MeshAttribute final : public Texture {
  public:
    explicit MeshAttribute(const MeshAttributeParameters& parameters) : p_(parameters) {}

    Rgb rgb(const SurfaceInteraction& si) const override {
        Rgb value(0.0f);
        if (!si.shape || !si.shape->attribute(p_.name, si, value)) return Rgb(0.0f);
        return value * p_.scale;
    }
    float scalar(const SurfaceInteraction& si) const override {
        const Rgb c = rgb(si);
        return c.x == c.y && c.y == c.z ? c.x : luminance(c);
    }
    /// An attribute is not a function of uv.
    Vec2f gradient(const SurfaceInteraction&) const override { return {0, 0}; }
    /// Not known without the mesh; a middle value serves what the mean is for.
    Rgb mean() const override { return Rgb(0.5f * p_.scale); }

  private:
    MeshAttributeParameters p_;
};

}  // namespace

TexturePtr makeMeshAttribute(const MeshAttributeParameters& parameters) {
    return std::make_shared<MeshAttribute>(parameters);
}

}  // namespace metrolux::core
