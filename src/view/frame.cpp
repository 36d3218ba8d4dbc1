#include "view/frame.h"

#include "base/math.h"
#include "image/blocking.h"

#include <Imath/half.h>

#include <bit>
#include <cmath>

namespace metrolux::core::view {

std::vector<float> relativeErrors(std::span<const float> color, std::span<const float> variance) {
    const size_t count = variance.size();
    const auto luminanceAt = [&](size_t i) {
        return double(luminance({color[3 * i], color[3 * i + 1], color[3 * i + 2]}));
    };
    double mean = 0;
    for (size_t i = 0; i < count; ++i) mean += luminanceAt(i) / double(count);
    const double darkness = BlockedErrorEstimate::kDarkness * mean * mean;
    std::vector<float> errors(count);
    for (size_t i = 0; i < count; ++i) {
        const double y = luminanceAt(i), below = y * y + darkness;
        errors[i] = below > 0 ? float(std::sqrt(double(variance[i]) / below)) : 0.0f;
    }
    return errors;
}

std::string halfFloats(std::span<const float> values) {
    static_assert(std::endian::native == std::endian::little, "bytes are sent as they lie in memory");
    std::string bytes(2 * values.size(), '\0');
    for (size_t i = 0; i < values.size(); ++i) {
        const uint16_t bits = Imath::half(values[i]).bits();
        bytes[2 * i] = static_cast<char>(bits & 0xff);
        bytes[2 * i + 1] = static_cast<char>(bits >> 8);
    }
    return bytes;
}

}  // namespace metrolux::core::view
