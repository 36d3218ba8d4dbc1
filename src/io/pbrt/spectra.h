#pragma once
/// Colors and spectra of pbrt as linear Rec.709 RGB. pbrt renders spectra; here a spectrum is the color that
/// it has: a reflectance that of its surface in white light, so that flat ones are gray; emission its
/// chromaticity with the luminance 1, because pbrt divides a light's spectrum by its own luminance before
/// `scale`.

#include "io/pbrt/parameters.h"

#include <array>

namespace metrolux::core::pbrt {

/// The primaries that `rgb` values have (ColorSpace).
class ColorSpace {
  public:
    ColorSpace() = default;
    /// Throws Error for an unknown name.
    explicit ColorSpace(const std::string& name);
    /// To Rec.709, not negative.
    Rgb convert(const Rgb& color) const;

  private:
    std::array<float, 9> rows_{1, 0, 0, 0, 1, 0, 0, 0, 1};
    bool isIdentity_ = true;
};

/// Of a surface or a medium's coefficient: rgb, spectrum, a number; not limited to 1.
Rgb surfaceColor(const Parameter& parameter, const ColorSpace& space, Reading& reading);
/// Of a light, as above.
Rgb lightColor(const Parameter& parameter, const ColorSpace& space, Reading& reading);

/// An index of refraction: a number, or the name of a glass.
double indexOfRefraction(const Parameters& parameters, const std::string& name, double fallback,
                         Reading& reading);

/// The name that Dispersion knows it by, if the parameter is the name of a glass.
std::optional<std::string> namedGlass(const Parameters& parameters, const std::string& name);

/// Of a conductor: both of "eta" and "k" or of another prefix, by name or by value. Copper if absent.
struct ConductorColors {
    Rgb eta, k;
};
ConductorColors conductorColors(const Parameters& parameters, const std::string& prefix,
                                const ColorSpace& space, Reading& reading);

}  // namespace metrolux::core::pbrt
