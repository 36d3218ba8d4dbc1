#include "endpoint/lights/texture_table.h"

namespace metrolux::core {

namespace {

constexpr int kMaxTableSide = 2048;
constexpr int kSubSamples = 2;  // per axis and cell
constexpr float kUniformShare = 0.1f;

}  // namespace

Rgb textureAt(const Texture& texture, const Vec2f& uv) {
    SurfaceInteraction si{};
    si.ng = si.ns = {0, 0, 1};
    si.s = {1, 0, 0};
    si.uv = uv;
    return texture.rgb(si);
}

Distribution2D luminanceTable(const Texture& texture) {
    const Vec2i resolution = texture.resolution();
    const int width = std::clamp(resolution.x, 1, kMaxTableSide),
              height = std::clamp(resolution.y, 1, kMaxTableSide);
    std::vector<float> table(size_t(width) * height);
    double sum = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            float value = 0;
            for (int j = 0; j < kSubSamples; ++j)
                for (int i = 0; i < kSubSamples; ++i) {
                    const Vec2f uv(
                        (static_cast<float>(x) + (static_cast<float>(i) + 0.5f) / kSubSamples) / width,
                        (static_cast<float>(y) + (static_cast<float>(j) + 0.5f) / kSubSamples) / height);
                    value += std::max(luminance(textureAt(texture, uv)), 0.0f);
                }
            table[size_t(y) * width + x] = value;
            sum += value;
        }
    const float mean = static_cast<float>(sum / static_cast<double>(table.size()));
    const float floor = mean > 0 ? mean * (kUniformShare / (1 - kUniformShare)) : 1.0f;
    for (float& value : table) value += floor;
    return Distribution2D(table, width, height);
}

}  // namespace metrolux::core
