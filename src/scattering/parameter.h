#pragma once
/// Inputs of scattering models: a texture, or its value when it is constant (no virtual call in the inner
/// loop).

#include "scattering/texture.h"

#include <utility>

namespace metrolux::core {

class ScalarParameter {
  public:
    /// `fallback` is the value where no texture is given.
    ScalarParameter(TexturePtr texture, float fallback)
        : constant_(texture && texture->isConstant() ? texture->scalar(SurfaceInteraction{}) : fallback),
          texture_(texture && texture->isConstant() ? nullptr : std::move(texture)) {}
    float operator()(const SurfaceInteraction& si) const {
        return texture_ ? texture_->scalar(si) : constant_;
    }
    bool isZero() const { return !texture_ && constant_ == 0; }
    bool isConstant() const { return !texture_; }

  private:
    float constant_;
    TexturePtr texture_;
};

class ColorParameter {
  public:
    ColorParameter(TexturePtr texture, float fallback)
        : constant_(texture && texture->isConstant() ? texture->mean() : Rgb(fallback)),
          texture_(texture && texture->isConstant() ? nullptr : std::move(texture)) {}
    Rgb operator()(const SurfaceInteraction& si) const { return texture_ ? texture_->rgb(si) : constant_; }
    Rgb mean() const { return texture_ ? texture_->mean() : constant_; }
    const Texture* texture() const { return texture_.get(); }  ///< null when constant

  private:
    Rgb constant_;
    TexturePtr texture_;
};

/// Share of the specular lobe in samples of a diffuse base and a specular coat, by their mean colors.
inline float specularShare(const ColorParameter& diffuse, const ColorParameter& specular) {
    const float diffuseMean = average(diffuse.mean()), specularMean = average(specular.mean());
    return specularMean > 0 ? specularMean / (diffuseMean + specularMean) : 0.0f;
}

/// A color as a reflectance: each channel in [0, 1]. For albedo(), which promises that range.
inline Rgb clampUnit(const Rgb& c) {
    return {std::clamp(c.x, 0.0f, 1.0f), std::clamp(c.y, 0.0f, 1.0f), std::clamp(c.z, 0.0f, 1.0f)};
}

}  // namespace metrolux::core
