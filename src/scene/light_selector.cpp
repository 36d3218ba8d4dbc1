#include "scene/light_selector.h"

#include "base/error.h"

namespace metrolux::core {

std::vector<double> mixedWithEven(std::span<const double> powers, double evenShare) {
    double total = 0;
    for (const double p : powers) total += p;
    const double even = 1.0 / double(powers.size());
    std::vector<double> result;
    result.reserve(powers.size());
    for (const double p : powers)
        result.push_back(total > 0 ? (1 - evenShare) * p / total + evenShare * even : even);
    return result;
}

LightSelector::LightSelector(std::span<const LightPtr> lights, const SceneBounds& scene) {
    std::vector<LightBounds> bounds;
    std::vector<double> powers;
    places_.reserve(lights.size());
    for (const LightPtr& light : lights) {
        Place place;
        const auto index = static_cast<uint32_t>(places_.size());
        if (light->isInfinite()) {
            place = {Place::Kind::Infinite, static_cast<uint32_t>(infiniteLights_.size())};
            infiniteLights_.push_back(index);
            powers.push_back(light->power());
            infiniteIrradiance_ += powers.back() / (std::numbers::pi * sqr(double(scene.radius)));
        } else if (const std::optional<LightBounds> b = light->bounds()) {
            place = {Place::Kind::Tree, static_cast<uint32_t>(treeLights_.size())};
            if (!isFinite(b->lower) || !isFinite(b->upper) || !std::isfinite(b->intensity))
                throw Error("light {} of {}: its place or its intensity is not finite", index + 1,
                            lights.size());
            treeLights_.push_back(index);
            bounds.push_back(*b);
        }
        places_.push_back(place);
    }
    tree_ = LightTree(bounds);
    if (!powers.empty()) infinite_ = DiscreteDistribution(mixedWithEven(powers, 0.5));
}

double LightSelector::infiniteShare(double treeIrradiance) const {
    const double sum = infiniteIrradiance_ + treeIrradiance;
    return sum > 0 ? 0.25 + 0.5 * infiniteIrradiance_ / sum : 0.5;
}

LightSelector::Choice LightSelector::sample(const Vec3f& x, float& u) const {
    if (tree_.size() == 0) return sampleInfinite(1, u);
    if (infinite_.empty() && tree_.size() == 1) return {treeLights_[0], 1};
    const LightTree::Cut cut = tree_.cut(x);
    const double share = infinite_.empty() ? 0 : infiniteShare(cut.irradiance);
    if (double(u) < share) {
        u = std::min(static_cast<float>(double(u) / share), kOneMinusEpsilon);
        return sampleInfinite(share, u);
    }
    double rest = (double(u) - share) / (1 - share);
    const LightTree::Choice choice = tree_.sample(cut, rest);
    u = std::min(static_cast<float>(rest), kOneMinusEpsilon);
    return {treeLights_[choice.light], static_cast<float>((1 - share) * choice.probability)};
}

LightSelector::Choice LightSelector::sampleInfinite(double share, float& u) const {
    const size_t i = infinite_.sample(u);
    return {infiniteLights_[i], static_cast<float>(share * infinite_.pmf(i))};
}

float LightSelector::probability(const Vec3f& x, uint32_t light) const {
    const Place& place = places_[light];
    if (place.kind == Place::Kind::None) return 0;
    const bool infinite = place.kind == Place::Kind::Infinite;
    if (tree_.size() == 0) return static_cast<float>(infinite_.pmf(place.index));
    if (infinite_.empty() && tree_.size() == 1) return 1;
    const LightTree::Cut cut = tree_.cut(x);
    const double share = infinite_.empty() ? 0 : infiniteShare(cut.irradiance);
    return static_cast<float>(infinite ? share * infinite_.pmf(place.index)
                                       : (1 - share) * tree_.probability(cut, place.index));
}

}  // namespace metrolux::core
