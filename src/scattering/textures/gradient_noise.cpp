#include "scattering/textures/gradient_noise.h"

#include <array>
#include <cmath>

namespace metrolux::core {
namespace {

/// Perlin's permutation of 0 to 255.
constexpr std::array<uint8_t, 256> kPermutation = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,
    69,  142, 8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,
    94,  252, 219, 203, 117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136,
    171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166, 77,  146, 158, 231, 83,  111, 229, 122,
    60,  211, 133, 230, 220, 105, 92,  41,  55,  46,  245, 40,  244, 102, 143, 54,  65,  25,  63,  161,
    1,   216, 80,  73,  209, 76,  132, 187, 208, 89,  18,  169, 200, 196, 135, 130, 116, 188, 159, 86,
    164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250, 124, 123, 5,   202, 38,  147, 118, 126,
    255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,  182, 189, 28,  42,  223, 183, 170, 213,
    119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,   129, 22,  39,  253,
    19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,  242, 193,
    238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,
    181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,
    222, 114, 67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

/// The product of the offset with one of twelve gradients, the midpoints of a cube's edges.
float slopeAt(uint32_t x, uint32_t y, uint32_t z, const Vec3f& d) {
    const auto permuted = [](uint32_t i) { return uint32_t(kPermutation[i & 255]); };
    const uint32_t hash = permuted(permuted(permuted(x) + y) + z) & 15;
    const float u = hash < 8 || hash == 12 || hash == 13 ? d.x : d.y;
    const float v = hash < 4 || hash == 12 || hash == 13 ? d.y : d.z;
    return (hash & 1 ? -u : u) + (hash & 2 ? -v : v);
}

float smooth(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

template <class Octave>
float sum(const Vec3f& p, float roughness, int octaves, const Octave& octave) {
    float result = 0, frequency = 1, weight = 1;
    for (int i = 0; i < octaves; ++i) {
        result += weight * octave(gradientNoise(p * frequency));
        frequency *= 1.99f;
        weight *= roughness;
    }
    return result;
}

}  // namespace

float gradientNoise(const Vec3f& p) {
    constexpr float kFarthest = 1 << 30;
    if (!(std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest && std::abs(p.z) < kFarthest)) return 0;
    const Vec3f low(std::floor(p.x), std::floor(p.y), std::floor(p.z)), d = p - low;
    const auto cell = [&](int axis) { return static_cast<uint32_t>(static_cast<int32_t>(low[axis])); };
    const uint32_t x = cell(0), y = cell(1), z = cell(2);
    const auto corner = [&](uint32_t i, uint32_t j, uint32_t k) {
        return slopeAt(x + i, y + j, z + k,
                       d - Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)));
    };
    const float wx = smooth(d.x), wy = smooth(d.y), wz = smooth(d.z);
    const auto edge = [&](uint32_t j, uint32_t k) { return lerp(wx, corner(0, j, k), corner(1, j, k)); };
    const auto face = [&](uint32_t k) { return lerp(wy, edge(0, k), edge(1, k)); };
    return lerp(wz, face(0), face(1));
}

float fractalNoise(const Vec3f& p, float roughness, int octaves) {
    return sum(p, roughness, octaves, [](float x) { return x; });
}

float turbulence(const Vec3f& p, float roughness, int octaves) {
    return sum(p, roughness, octaves, [](float x) { return std::abs(x); });
}

}  // namespace metrolux::core
