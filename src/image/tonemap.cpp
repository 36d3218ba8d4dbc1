#include "image/tonemap.h"

namespace metrolux::core {

std::optional<ToneCurve> toneCurveFromName(std::string_view name) {
    if (name == "srgb") return ToneCurve::Srgb;
    if (name == "filmic") return ToneCurve::Filmic;
    return std::nullopt;
}

float encodeSrgb(float linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 1;
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float decodeSrgb(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

float filmicCurve(float linear) {
    // Beyond this the curve is 1 to 8 bits, and squares could overflow.
    const float x = std::clamp(linear, 0.0f, 1e4f);
    return std::min(1.0f, x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f));
}

Rgb tonemap(const Rgb& linear, float exposure, ToneCurve curve) {
    const float scale = std::exp2(exposure);
    Rgb result;
    for (int c = 0; c < 3; ++c) {
        const float value = std::isnan(linear[c]) ? 0.0f : linear[c] * scale;
        result[c] = encodeSrgb(curve == ToneCurve::Filmic ? filmicCurve(value) : value);
    }
    return result;
}

}  // namespace metrolux::core
