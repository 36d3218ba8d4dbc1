#pragma once
#include "base/math.h"

#include <cmath>
#include <vector>

namespace metrolux::core {

/// Second moments of estimates of pixels, of what eye subpaths would be surprised by (EyeTail).
struct Surprise {
    double alone = 0;     ///< if eye subpaths were alone
    double together = 0;  ///< of all techniques with their weights
    Surprise& operator+=(const Surprise& s) {
        alone += s.alone;
        together += s.together;
        return *this;
    }
    friend Surprise operator*(double factor, const Surprise& s) {
        return {factor * s.alone, factor * s.together};
    }
    template <class Archive>
    void serialize(Archive& archive) {
        archive(alone, together);
    }
};

/// What a splat counts in F(u): as its luminance where no component is negative. Where some are, as in the
/// color of a single wavelength, luminance may vanish, and F must be positive wherever something is
/// contributed.
inline float magnitude(const Rgb& c) { return luminance({std::abs(c.x), std::abs(c.y), std::abs(c.z)}); }

/// What one light subpath contributes: to the pixel of an eye subpath (connections and merges), or to a
/// raster position (connections to the camera), which the film spreads with its filter.
struct SplatList {
    struct PixelSplat {
        uint32_t pixel;  ///< index within the rendered window, row by row
        Rgb value;
        template <class Archive>
        void serialize(Archive& archive) {
            archive(pixel, value);
        }
    };
    struct FilmSplat {
        Vec2f position;  ///< raster position in pixels of the full image
        Rgb value;       ///< per pixel area
        template <class Archive>
        void serialize(Archive& archive) {
            archive(position, value);
        }
    };
    std::vector<PixelSplat> pixels;
    std::vector<FilmSplat> film;
    /// The part of size() that eye subpaths compete for: luminances times the MIS weight that hit and nee
    /// have of the same paths.
    double shared = 0;
    Surprise surprise{};  ///< sum of EyeTail::surprise(), where it is asked for

    template <class Archive>
    void serialize(Archive& archive) {
        archive(pixels, film, shared, surprise);
    }
    void add(uint32_t pixel, const Rgb& value, float eyeShare) {
        pixels.push_back({pixel, value});
        shared += magnitude(value) * eyeShare;
    }
    void add(const Vec2f& position, const Rgb& value, float eyeShare) {
        film.push_back({position, value});
        shared += magnitude(value) * eyeShare;
    }
    void clear() {
        shared = 0;
        surprise = {};
        pixels.clear();
        film.clear();
    }
    bool empty() const { return pixels.empty() && film.empty(); }
    /// Sum of magnitudes: F(u) of docs/explain/algorithm.md section 3. Without signs: eye subpaths in a
    /// negative lobe of the reconstruction filter make negative splats.
    double size() const {
        double sum = 0;
        for (const PixelSplat& s : pixels) sum += magnitude(s.value);
        for (const FilmSplat& s : film) sum += magnitude(s.value);
        return sum;
    }
};

}  // namespace metrolux::core
