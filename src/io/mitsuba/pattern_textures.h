#pragma once
#include "io/mitsuba/context.h"

namespace metrolux::core::mitsuba {

/// Textures that neither Mitsuba has and other formats do: `mapped`, `noise`, `cells` and `combination`
/// (scattering/textures/positional.h).
const std::vector<std::string>& patternTextureNames();
/// Throws Error for another type.
TexturePtr makePatternTexture(const Element& element, LoadContext& context);

/// What a part of a pattern holds: a color, or a nested texture. No range is imposed, since only the reader
/// of the pattern knows it.
TexturePtr patternColor(const Element& element, const std::string& name, float fallback, LoadContext& context,
                        bool emission);

}  // namespace metrolux::core::mitsuba
