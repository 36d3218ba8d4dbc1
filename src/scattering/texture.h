#pragma once
#include "base/math.h"
#include "geometry/interaction.h"

#include <memory>
#include <vector>

namespace metrolux::core {

/// A spatially varying RGB value. Values that describe reflectances are linear Rec.709 in [0, 1]; values of
/// emitters are radiances.
class Texture {
  public:
    virtual ~Texture() = default;
    virtual Rgb rgb(const SurfaceInteraction& si) const = 0;
    /// The value as a scalar (roughness, opacity, weights ...): for color images Rec.709 luminance.
    virtual float scalar(const SurfaceInteraction& si) const { return luminance(rgb(si)); }
    /// d scalar / du, d scalar / dv at si, for bump maps. Constant textures return zero.
    virtual Vec2f gradient(const SurfaceInteraction& si) const;
    /// A mean over the unit uv square (exact or by texels): for light selection and lobe selection.
    virtual Rgb mean() const = 0;
    virtual bool isConstant() const { return false; }
    /// Resolution that an importance table should have to follow the texture; (1,1) for constants.
    virtual Vec2i resolution() const { return {1, 1}; }
};
using TexturePtr = std::shared_ptr<const Texture>;

}  // namespace metrolux::core
