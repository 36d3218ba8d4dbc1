#pragma once
/// A dielectric interface of microfacets with what it lets through, tabulated: for one roughness, or for that
/// of a texture.

#include "scattering/microfacet.h"
#include "scattering/parameter.h"

#include <array>
#include <optional>

namespace metrolux::core {

class RoughInterface {
  public:
    static constexpr size_t kSize = 64;
    /// Transmittance from outside at equidistant cosines, and the diffuse reflectance from inside.
    struct Table {
        std::array<float, kSize> transmittance{};
        float internal = 0;
    };
    /// The interface at a point of the surface: between two tables, or in one of them.
    struct At {
        MicrofacetDistribution facets;
        const Table *low, *high;
        float between = 0;

        float transmittance(float cosine) const {
            const float t = lookUp(*low, cosine);
            return between == 0 ? t : lerp(between, t, lookUp(*high, cosine));
        }
        float internal() const {
            return between == 0 ? low->internal : lerp(between, low->internal, high->internal);
        }

      private:
        static float lookUp(const Table& table, float cosine);
        friend class RoughInterface;
    };

    /// `eta`: index inside over that outside. `needsInternal`: the reflectance from inside is asked for.
    RoughInterface(const MicrofacetDistribution& facets, float eta, bool needsInternal);
    /// The roughness is isotropic and cut at kWidest. Throws nothing.
    RoughInterface(MicrofacetType type, TexturePtr alpha, float eta, bool needsInternal);
    static constexpr float kWidest = 4;

    At operator()(const SurfaceInteraction& si) const;

  private:
    static Table tabulate(const MicrofacetDistribution& facets, float eta, bool needsInternal);
    static float alphaOf(size_t table);

    std::optional<MicrofacetDistribution> constant_;
    MicrofacetType type_ = MicrofacetType::Beckmann;
    ScalarParameter alpha_{nullptr, 0};
    std::vector<Table> tables_;
};

}  // namespace metrolux::core
