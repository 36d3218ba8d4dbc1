#pragma once
#include "base/math.h"

#include <optional>
#include <string_view>

namespace metrolux::core {

enum class ToneCurve { Srgb, Filmic };

/// "srgb" or "filmic".
std::optional<ToneCurve> toneCurveFromName(std::string_view name);

/// Transfer functions of IEC 61966-2-1. Encoding clamps to [0, 1]; a NaN encodes as 0.
float encodeSrgb(float linear);
float decodeSrgb(float encoded);

/// K. Narkowicz's rational fit of the ACES reference tone curve (2015, knarkowicz.wordpress.com, "ACES Filmic
/// Tone Mapping Curve"), linear to linear display light. Rolls off highlights instead of clipping them.
float filmicCurve(float linear);

/// Linear scene value to encoded display value: exposure in stops, curve, sRGB encoding.
Rgb tonemap(const Rgb& linear, float exposure, ToneCurve curve);

}  // namespace metrolux::core
