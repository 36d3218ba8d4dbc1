#pragma once
/// Many lights of mixed kinds, at random.

#include "base/rng.h"
#include "endpoint/lights.h"
#include "scattering/textures/constant.h"

#include <memory>
#include <vector>

namespace metrolux::core::test {

/// Keeps the shapes of area lights, to which lights point.
struct ManyLights {
    std::vector<ShapePtr> shapes;
    std::vector<LightPtr> lights;

    void area(ShapePtr shape, const Rgb& radiance) {
        lights.push_back(makeAreaLight({shape.get(), makeConstantTexture(radiance)}));
        shapes.push_back(std::move(shape));
    }
};

inline Vec3f randomPoint(CounterRng& rng, float extent) {
    const float x = rng.next1D(), y = rng.next1D(), z = rng.next1D();
    return Vec3f(2 * x - 1, 2 * y - 1, 2 * z - 1) * extent;
}

inline Transform randomPlace(CounterRng& rng, const Vec3f& center, float extent) {
    const Vec3f offset = randomPoint(rng, extent), axis = randomPoint(rng, 1) + Vec3f(0, 0, 1e-3f);
    return Transform::translate(center + offset) * Transform::rotate(axis, 360 * rng.next1D());
}

/// `count` lights of all kinds that have a place, within a cube of half-size `extent` around `center`; their
/// sizes are up to `size`, their intensities spread over a factor of 1000.
inline ManyLights mixedLights(int count, uint64_t seed, const Vec3f& center = Vec3f(0.0f), float extent = 10,
                              float size = 0.5f) {
    ManyLights result;
    CounterRng rng(hashKey(seed));
    const TexturePtr picture = makeConstantTexture(Rgb(0.7f));
    for (int i = 0; i < count; ++i) {
        const Transform place = randomPlace(rng, center, extent);
        const float s = size * (0.05f + 0.95f * rng.next1D());
        const Rgb value(std::pow(1000.0f, rng.next1D()));
        const Transform scaled = place * Transform::scale({s, 0.4f * s, s});
        switch (i % 10) {
            case 0:
                result.area(makeRectangle(scaled, false), value);
                break;
            case 1:
                result.area(makeRectangle(scaled, true), value);
                break;
            case 2:
                result.area(makeDisk(scaled, rng.next1D() < 0.5f), value);
                break;
            case 3:
                result.area(makeSphere(place, Vec3f(0.0f), s, false), value);
                break;
            case 4:
                result.area(makeSphere(place, Vec3f(0.0f), s, true), value);
                break;
            case 5:
                result.area(makeCylinder(place, Vec3f(0.0f), {0, 0, s}, 0.3f * s, false), value);
                break;
            case 6:
                result.area(makeCube(scaled, false), value);
                break;
            case 7:
                result.lights.push_back(makePointLight({place.point(Vec3f(0.0f)), value}));
                break;
            case 8: {
                const float cutoff = 3 + 170 * sqr(rng.next1D());
                result.lights.push_back(makeSpotLight({place, value, cutoff, 0.6f * cutoff, nullptr}));
                break;
            }
            default:
                result.lights.push_back(
                    makeProjector({place, picture, value.x, 0.1f + 2 * rng.next1D(), 1.5f}));
        }
    }
    return result;
}

}  // namespace metrolux::core::test
