#include "scattering/rough_interface.h"

#include "base/parallel.h"

namespace metrolux::core {
namespace {

constexpr size_t kTables = 24;  // of a texture: closer together where surfaces are smooth

}  // namespace

float RoughInterface::At::lookUp(const Table& table, float cosine) {
    const float x = cosine * (kSize - 1);
    const size_t i = std::min(static_cast<size_t>(x), kSize - 2);
    return lerp(x - static_cast<float>(i), table.transmittance[i], table.transmittance[i + 1]);
}

/// The same nodes and quadratures as in Mitsuba 3, so that the images agree. From inside the integrand has a
/// jump (total reflection) and takes more nodes.
RoughInterface::Table RoughInterface::tabulate(const MicrofacetDistribution& facets, float eta,
                                               bool needsInternal) {
    Table result;
    std::array<float, kSize> reflectance{};
    parallelFor(kSize, [&](size_t i) {
        const float cosine = std::max(1e-6f, static_cast<float>(i) / (kSize - 1));
        const Vec3f w(safeSqrt(1.0f - cosine * cosine), 0, cosine);
        const auto nodes = [](float e) { return e > 1 ? 32 : 128; };
        result.transmittance[i] = microfacetTransmittance(facets, w, eta, nodes(eta));
        if (needsInternal)
            reflectance[i] = cosine * microfacetReflectance(facets, w, 1.0f / eta, nodes(1.0f / eta));
    });
    for (const float r : reflectance) result.internal += 2.0f * r / kSize;
    return result;
}

float RoughInterface::alphaOf(size_t table) {
    const float x = static_cast<float>(table) / (kTables - 1);
    return kWidest * x * x;
}

RoughInterface::RoughInterface(const MicrofacetDistribution& facets, float eta, bool needsInternal)
    : constant_(facets), tables_{tabulate(facets, eta, needsInternal)} {}

RoughInterface::RoughInterface(MicrofacetType type, TexturePtr alpha, float eta, bool needsInternal)
    : type_(type), alpha_(std::move(alpha), 0.1f) {
    for (size_t i = 0; i < kTables; ++i)
        tables_.push_back(tabulate(MicrofacetDistribution(type, alphaOf(i), alphaOf(i)), eta, needsInternal));
}

RoughInterface::At RoughInterface::operator()(const SurfaceInteraction& si) const {
    if (constant_) return {*constant_, &tables_[0], &tables_[0]};
    const float alpha = std::clamp(alpha_(si), 0.0f, kWidest);
    const float x = std::sqrt(alpha / kWidest) * (kTables - 1);
    const size_t i = std::min(static_cast<size_t>(x), kTables - 2);
    const float low = alphaOf(i), high = alphaOf(i + 1);
    return {MicrofacetDistribution(type_, alpha, alpha), &tables_[i], &tables_[i + 1],
            std::clamp((alpha - low) / (high - low), 0.0f, 1.0f)};
}

}  // namespace metrolux::core
