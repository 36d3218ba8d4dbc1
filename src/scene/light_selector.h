#pragma once
#include "base/distribution.h"
#include "scene/light_tree.h"

#include <span>
#include <vector>

namespace metrolux::core {

/// Probabilities of a choice by power of which a share is even, because power does not tell what reaches a
/// given point; all of it where no light has power.
std::vector<double> mixedWithEven(std::span<const double> powers, double evenShare);

/// Picks lights for next-event estimation at x. Lights that have a place are in a light tree; infinite ones
/// are chosen half by power, half evenly. Between the two it is half by what they could send to x (the tree's
/// estimate of irradiance; the power of the infinite ones is flux through a disk around the scene), half
/// evenly, because what x sees of either is not known. Lights that cannot be connected are never chosen.
class LightSelector {
  public:
    LightSelector() = default;
    /// The lights know the scene's bounds.
    LightSelector(std::span<const LightPtr> lights, const SceneBounds& scene);

    bool empty() const { return tree_.size() == 0 && infinite_.empty(); }

    struct Choice {
        uint32_t light = 0;  ///< index into the constructor's lights
        float probability = 0;
    };
    /// `u` is rescaled to a fresh uniform number in [0, 1). Not when empty().
    Choice sample(const Vec3f& x, float& u) const;
    /// What sample() reports for this light, to the bit.
    float probability(const Vec3f& x, uint32_t light) const;

  private:
    /// Where a light is found.
    struct Place {
        enum class Kind : uint8_t { None, Tree, Infinite } kind = Kind::None;
        uint32_t index = 0;  ///< in the tree or among the infinite lights
    };

    double infiniteShare(double treeIrradiance) const;
    Choice sampleInfinite(double share, float& u) const;

    std::vector<Place> places_;  // of each light
    LightTree tree_;
    DiscreteDistribution infinite_;
    double infiniteIrradiance_ = 0;
    std::vector<uint32_t> treeLights_, infiniteLights_;
};

}  // namespace metrolux::core
