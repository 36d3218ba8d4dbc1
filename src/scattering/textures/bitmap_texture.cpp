#include "scattering/textures/bitmap_texture.h"

#include "base/error.h"

#include <array>
#include <bit>
#include <optional>

namespace metrolux::core {
namespace {

class BitmapTexture final : public Texture {
  public:
    explicit BitmapTexture(const BitmapTextureParameters& parameters)
        : image_(parameters), palette_(Palette::of(*parameters.pixels)) {
        if (palette_) image_.pixels.reset();
        std::array<double, 3> sum{};
        for (int y = 0; y < image_.height; ++y)
            for (int x = 0; x < image_.width; ++x) {
                const Rgb c = texel(x, y);
                for (size_t k = 0; k < 3; ++k) sum[k] += c[static_cast<int>(k)];
            }
        const double scale = 1.0 / (static_cast<double>(image_.width) * image_.height);
        for (size_t k = 0; k < 3; ++k) mean_[static_cast<int>(k)] = static_cast<float>(sum[k] * scale);
    }

    Rgb rgb(const SurfaceInteraction& si) const override {
        const Vec2f p = pixelPosition(si);
        if (nearest()) return wrapped(floorInt(p.x), floorInt(p.y));
        const Patch patch = patchAt(p);
        return lerp(patch.fy, lerp(patch.fx, patch.c00, patch.c10), lerp(patch.fx, patch.c01, patch.c11));
    }

    float scalar(const SurfaceInteraction& si) const override {
        const Rgb c = rgb(si);
        return image_.channels == 1 ? c.x : luminance(c);
    }

    /// Bilinear: the derivative of the patch. Nearest has none; the central difference of the neighbor
    /// texels stands in for it.
    Vec2f gradient(const SurfaceInteraction& si) const override {
        const Vec2f p = pixelPosition(si);
        Vec2f perTexel;
        if (nearest()) {
            const int x = floorInt(p.x), y = floorInt(p.y);
            perTexel = {0.5f * (height(wrapped(x + 1, y)) - height(wrapped(x - 1, y))),
                        0.5f * (height(wrapped(x, y + 1)) - height(wrapped(x, y - 1)))};
        } else {
            const Patch patch = patchAt(p);
            const float h00 = height(patch.c00), h10 = height(patch.c10), h01 = height(patch.c01),
                        h11 = height(patch.c11);
            perTexel = {metrolux::core::lerp(patch.fy, h10 - h00, h11 - h01),
                        metrolux::core::lerp(patch.fx, h01 - h00, h11 - h10)};
        }
        return image_.toUv.pullBack(
            {perTexel.x * static_cast<float>(image_.width), perTexel.y * static_cast<float>(image_.height)});
    }

    Rgb mean() const override { return mean_; }
    bool isConstant() const override {
        return image_.width == 1 && image_.height == 1 && !endsAtBorder(image_.wrapU) &&
               !endsAtBorder(image_.wrapV);
    }
    Vec2i resolution() const override { return {image_.width, image_.height}; }

  private:
    /// The values of an image of 8 bits per channel, which most are: a quarter of the memory, and of the
    /// caches. Exact.
    struct Palette {
        std::array<float, 256> values;
        std::vector<uint8_t> codes;  ///< of each value of the image

        /// Nothing when there are more than 256 values.
        static std::optional<Palette> of(const std::vector<float>& pixels) {
            constexpr size_t kSlots = 2048;  // sparse, so that collisions are rare
            std::array<uint32_t, kSlots> keys{};
            std::array<int, kSlots> codes;
            codes.fill(-1);
            Palette result;
            int count = 0;
            result.codes.reserve(pixels.size());
            for (const float value : pixels) {
                const auto bits = std::bit_cast<uint32_t>(value);
                size_t slot = (bits * 0x9e3779b1u) >> 21;
                while (codes[slot] >= 0 && keys[slot] != bits) slot = (slot + 1) % kSlots;
                if (codes[slot] < 0) {
                    if (count == 256) return std::nullopt;
                    keys[slot] = bits;
                    codes[slot] = count;
                    result.values[static_cast<size_t>(count++)] = value;
                }
                result.codes.push_back(static_cast<uint8_t>(codes[slot]));
            }
            return result;
        }
    };

    /// Four texels and the position between them.
    struct Patch {
        Rgb c00, c10, c01, c11;
        float fx, fy;
    };

    static int floorInt(float x) { return static_cast<int>(std::floor(x)); }
    bool nearest() const { return image_.filter == BitmapTextureParameters::Filter::Nearest; }
    float height(const Rgb& c) const { return image_.channels == 1 ? c.x : luminance(c); }

    /// Mapped uv in texels; wild coordinates are kept within what an int can hold.
    Vec2f pixelPosition(const SurfaceInteraction& si) const {
        const Vec2f uv = image_.toUv(si.uv);
        const auto limited = [](float x) { return std::isfinite(x) ? std::clamp(x, -1e9f, 1e9f) : 0.0f; };
        return {limited(uv.x * static_cast<float>(image_.width)),
                limited(uv.y * static_cast<float>(image_.height))};
    }

    Patch patchAt(const Vec2f& p) const {
        const float px = p.x - 0.5f, py = p.y - 0.5f;
        const int x = floorInt(px), y = floorInt(py);
        const int x0 = wrapU(x), x1 = wrapU(x + 1);
        const int y0 = wrapV(y), y1 = wrapV(y + 1);
        return {texel(x0, y0),
                texel(x1, y0),
                texel(x0, y1),
                texel(x1, y1),
                px - static_cast<float>(x),
                py - static_cast<float>(y)};
    }

    using Wrap = BitmapTextureParameters::Wrap;
    static constexpr int kZero = -1, kOne = -2;  ///< in place of the index of a texel

    static bool endsAtBorder(Wrap mode) { return mode == Wrap::Zero || mode == Wrap::One; }
    int wrapU(int x) const { return wrap(x, image_.width, image_.wrapU); }
    int wrapV(int y) const { return wrap(y, image_.height, image_.wrapV); }
    static int wrap(int i, int size, Wrap mode) {
        if (i >= 0 && i < size) return i;
        if (mode == Wrap::Clamp) return std::clamp(i, 0, size - 1);
        if (endsAtBorder(mode)) return mode == Wrap::Zero ? kZero : kOne;
        const bool mirror = mode == Wrap::Mirror;
        const int period = mirror ? 2 * size : size;
        const int r = (i % period + period) % period;
        return r < size ? r : period - 1 - r;
    }
    Rgb wrapped(int x, int y) const { return texel(wrapU(x), wrapV(y)); }

    /// Of a texel's first value.
    size_t index(int x, int y) const {
        return (static_cast<size_t>(y) * static_cast<size_t>(image_.width) + static_cast<size_t>(x)) *
               static_cast<size_t>(image_.channels);
    }
    Rgb texel(int x, int y) const {
        if (x < 0 || y < 0) return Rgb((x < 0 ? x : y) == kOne ? 1.0f : 0.0f);
        const size_t i = index(x, y);
        if (palette_) {
            const uint8_t* c = &palette_->codes[i];
            const auto& values = palette_->values;
            return image_.channels == 1 ? Rgb(values[c[0]]) : Rgb(values[c[0]], values[c[1]], values[c[2]]);
        }
        const float* p = &(*image_.pixels)[i];
        return image_.channels == 1 ? Rgb(p[0]) : Rgb(p[0], p[1], p[2]);
    }

    BitmapTextureParameters image_;  ///< without pixels where there is a palette
    std::optional<Palette> palette_;
    Rgb mean_{0.0f};
};

}  // namespace

TexturePtr makeBitmapTexture(const BitmapTextureParameters& p) {
    if (p.width < 1 || p.height < 1 || (p.channels != 1 && p.channels != 3))
        throw Error(
            "bitmap texture: {} x {} pixels of {} channels; 1 or 3 channels and at least one pixel are "
            "expected",
            p.width, p.height, p.channels);
    const size_t size =
        static_cast<size_t>(p.width) * static_cast<size_t>(p.height) * static_cast<size_t>(p.channels);
    if (!p.pixels || p.pixels->size() != size)
        throw Error("bitmap texture: {} values for {} x {} x {}", p.pixels ? p.pixels->size() : 0, p.width,
                    p.height, p.channels);
    return std::make_shared<BitmapTexture>(p);
}

}  // namespace metrolux::core
