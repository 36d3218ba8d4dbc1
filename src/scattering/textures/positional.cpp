#include "scattering/textures/positional.h"

#include "base/error.h"
#include "geometry/shape.h"
#include "scattering/textures/gradient_noise.h"

namespace metrolux::core {
namespace {

Vec3f placed(const Transform& map, const Vec3f& p) { return Vec3f(map.exactPoint(Vec3d(p))); }

class MappedTexture final : public PositionalTexture {
  public:
    explicit MappedTexture(const MappedTextureParameters& p) : p_(p) {}

    Rgb rgb(const SurfaceInteraction& si) const override { return p_.texture->rgb(mapped(si)); }
    float scalar(const SurfaceInteraction& si) const override { return p_.texture->scalar(mapped(si)); }
    Rgb mean() const override { return p_.texture->mean(); }

  private:
    SurfaceInteraction mapped(const SurfaceInteraction& si) const {
        const Vec3f p = placed(p_.toTexture, si.p);
        const float turn = 1 / (2 * kPi);
        SurfaceInteraction result = si;
        switch (p_.mapping) {
            case UvMapping::Spherical: {
                const float phi = std::atan2(p.y, p.x);
                result.uv = {std::atan2(std::hypot(p.x, p.y), p.z) / kPi,
                             (phi < 0 ? phi + 2 * kPi : phi) * turn};
                break;
            }
            case UvMapping::Cylindrical:
                result.uv = {(kPi + std::atan2(p.y, p.x)) * turn, p.z};
                break;
            case UvMapping::Planar:
                result.uv = {p.x, p.y};
                break;
        }
        return result;
    }
    MappedTextureParameters p_;
};

class NoiseTexture final : public PositionalTexture {
  public:
    explicit NoiseTexture(const NoiseTextureParameters& p) : p_(p) {}

    Rgb rgb(const SurfaceInteraction& si) const override {
        const auto last = static_cast<float>(p_.colors.size() - 1);
        const float x =
            std::clamp((value(placed(p_.toTexture, si.p)) - p_.low) / (p_.high - p_.low), 0.0f, 1.0f) * last;
        const size_t i = std::min(static_cast<size_t>(x), p_.colors.size() - 2);
        return lerp(x - static_cast<float>(i), p_.colors[i], p_.colors[i + 1]);
    }

  private:
    float value(const Vec3f& p) const {
        using Kind = NoiseTextureParameters::Kind;
        switch (p_.kind) {
            case Kind::Fractal:
                return fractalNoise(p, p_.roughness, p_.octaves);
            case Kind::Turbulence:
                return turbulence(p, p_.roughness, p_.octaves);
            case Kind::Windy:
                return std::abs(fractalNoise(p * 0.1f, 0.5f, 3)) * fractalNoise(p, 0.5f, 6);
            case Kind::Marble:
                break;
        }
        const Vec3f scaled = p * p_.scale;
        return 0.5f +
               0.5f * std::sin(scaled.y + p_.variation * fractalNoise(scaled, p_.roughness, p_.octaves));
    }
    NoiseTextureParameters p_;
};

class Cells final : public PositionalTexture {
  public:
    explicit Cells(const CellsParameters& p) : p_(p) {}

    Rgb rgb(const SurfaceInteraction& si) const override { return at(si).rgb(si); }
    float scalar(const SurfaceInteraction& si) const override { return at(si).scalar(si); }
    Rgb mean() const override {
        const float share = p_.kind == CellsParameters::Kind::Cubes ? 0.5f : kDiscs * kPi * sqr(kRadius);
        return lerp(share, p_.second->mean(), p_.first->mean());
    }

  private:
    static constexpr float kRadius = 0.35f, kDiscs = 0.385f;  // so many of the squares have one

    const Texture& at(const SurfaceInteraction& si) const { return *(isFirst(si) ? p_.first : p_.second); }
    bool isFirst(const SurfaceInteraction& si) const {
        if (p_.kind == CellsParameters::Kind::Cubes) {
            const Vec3f p = placed(p_.toTexture, si.p);
            const double sum = std::floor(double(p.x)) + std::floor(double(p.y)) + std::floor(double(p.z));
            return std::fmod(sum, 2.0) == 0;
        }
        const Vec3f p = placed(p_.toTexture, {si.uv.x, si.uv.y, 0});
        const float s = std::floor(p.x + 0.5f), t = std::floor(p.y + 0.5f);
        const auto random = [&](float ds, float dt) { return gradientNoise({s + ds, t + dt, 0.5f}); };
        if (!(random(0.5f, 0.5f) > 0)) return false;
        const float shift = 0.5f - kRadius;
        const float x = s + shift * random(1.5f, 2.8f), y = t + shift * random(4.5f, 9.8f);
        return sqr(p.x - x) + sqr(p.y - y) < sqr(kRadius);
    }
    CellsParameters p_;
};

class Combination final : public PositionalTexture {
  public:
    explicit Combination(const CombinationParameters& p) : p_(p) {}

    Rgb rgb(const SurfaceInteraction& si) const override { return of(p_.first->rgb(si), p_.second->rgb(si)); }
    float scalar(const SurfaceInteraction& si) const override {
        return of(p_.first->scalar(si), p_.second->scalar(si));
    }
    Rgb mean() const override { return of(p_.first->mean(), p_.second->mean()); }
    Vec2i resolution() const override {
        const Vec2i a = p_.first->resolution(), b = p_.second->resolution();
        return {std::max(a.x, b.x), std::max(a.y, b.y)};
    }

  private:
    template <class T>
    T of(const T& a, const T& b) const {
        return p_.kind == CombinationParameters::Kind::Product ? a * b : a + b;
    }
    CombinationParameters p_;
};

}  // namespace

Vec2f PositionalTexture::gradient(const SurfaceInteraction& si) const {
    if (!si.shape) return {0, 0};
    const Partials tangents = partials(si);
    const auto slope = [&](const Vec3f& along, const Vec2f& uv) {
        // Not more than a thousandth of a unit in space.
        const float step = std::max(1e-3f / std::max(1.0f, along.length()), 2e-5f);
        const auto at = [&](float by) {
            SurfaceInteraction moved = si;
            moved.p = si.p + along * by;
            moved.uv = si.uv + uv * by;
            return scalar(moved);
        };
        return (at(step) - at(-step)) / (2 * step);
    };
    return {slope(tangents.dpdu, {1, 0}), slope(tangents.dpdv, {0, 1})};
}

/// Over some points of a large cube.
Rgb PositionalTexture::mean() const {
    constexpr int kPoints = 256;
    Rgb sum(0.0f);
    SurfaceInteraction si;
    for (int i = 0; i < kPoints; ++i) {
        const auto random = [i](float factor) {
            return 97 * (static_cast<float>(i) * factor - std::floor(static_cast<float>(i) * factor));
        };
        si.p = {random(0.8191725f), random(0.6710436f), random(0.5497005f)};  // Roberts' sequence
        sum += rgb(si);
    }
    return sum * (1.0f / kPoints);
}

TexturePtr makeMappedTexture(const MappedTextureParameters& parameters) {
    return std::make_shared<MappedTexture>(parameters);
}

TexturePtr makeNoiseTexture(const NoiseTextureParameters& p) {
    if (p.colors.size() < 2) throw Error("noise: found {} colors, expected 2 at least", p.colors.size());
    if (p.octaves < 1 || p.octaves > 32) throw Error("noise: found {} octaves, expected 1 to 32", p.octaves);
    if (!(p.low < p.high))
        throw Error("noise: the first color is for {}, the last for {}, expected a larger one", p.low,
                    p.high);
    return std::make_shared<NoiseTexture>(p);
}

TexturePtr makeCells(const CellsParameters& parameters) { return std::make_shared<Cells>(parameters); }

TexturePtr makeCombination(const CombinationParameters& parameters) {
    return std::make_shared<Combination>(parameters);
}

}  // namespace metrolux::core
