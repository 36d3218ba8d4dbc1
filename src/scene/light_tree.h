#pragma once
#include "endpoint/light.h"

#include <array>
#include <span>
#include <vector>

namespace metrolux::core {

/// Picks one of many lights for a point x by how much each could send there, were it visible [Conty Estevez &
/// Kulla 2018, Importance Sampling of Many Lights with Adaptive Tree Splitting]: a hierarchy of clusters,
/// eight children to a node. The estimate for a cluster is
///
///     intensity * cos(theta) / distance^2
///
/// from its center, its mean direction and its radius (the least distance). From within or near a cluster
/// that says little. Therefore such clusters are replaced by their children (their "splitting"), but only one
/// light is chosen: between all clusters of the cut that results by the estimates, then below it from node to
/// node.
///
/// A light's probability is zero only where its bounds say that no light of it arrives. Where that is so for
/// all children of a node they are chosen by intensity: probabilities sum to one at every x. Nothing is known
/// of x but its position.
class LightTree {
    static constexpr int kWidth = 8;
    static constexpr int kMaxExpanded = 64;
    using Lanes = std::array<float, kWidth>;

  public:
    LightTree() = default;
    /// At most 2^31 - 1 lights; their boxes and intensities must be finite. O(n log n).
    explicit LightTree(std::span<const LightBounds> lights);

    size_t size() const { return paths_.size(); }

    /// The cut at x. Its nodes are in breadth-first order from the root; those that replace children of a
    /// node follow each other.
    struct Cut {
        Vec3f x;
        double irradiance;  ///< estimate of what all lights send to x, were all visible and x turned to each
        double total;       ///< of the weights
        int count;          ///< of nodes
        std::array<uint32_t, kMaxExpanded> node;
        std::array<double, kMaxExpanded> sum;  ///< of a node's weights
        std::array<Lanes, kMaxExpanded> weights;
        std::array<uint8_t, kMaxExpanded> replaced;    ///< bits of children that are in the cut by their own
        std::array<uint8_t, kMaxExpanded> firstChild;  ///< where these begin
    };
    /// There must be a light.
    Cut cut(const Vec3f& x) const;

    struct Choice {
        uint32_t light = 0;  ///< index into the constructor's lights
        double probability = 0;
    };
    /// `u` in [0, 1) is rescaled to a fresh uniform number in [0, 1).
    Choice sample(const Cut& cut, double& u) const;
    /// What sample() reports for this light, to the bit.
    double probability(const Cut& cut, uint32_t light) const;

  private:
    static constexpr int kBitsPerLevel = 3;
    static constexpr int kMaxLevels = 64 / kBitsPerLevel;
    static constexpr uint32_t kIsLight = 1u << 31;

    /// Children side by side, so that they are weighed together. Unused ones have no intensity.
    struct alignas(64) Node {
        Lanes x{}, y{}, z{};                     ///< center of the sphere that holds the child
        Lanes radius2{};                         ///< its radius squared
        Lanes nearest2{1, 1, 1, 1, 1, 1, 1, 1};  ///< least squared distance that is reckoned with
        Lanes axisX{}, axisY{}, axisZ{}, cosNormals{}, sinNormals{}, cosEmission{};
        Lanes alignment{};  ///< of its lights' directions: 1 where they are the same, 0 where they cancel
        Lanes intensity{};
        std::array<uint32_t, kWidth> child{};  ///< node, or light | kIsLight
        uint32_t inner = 0;                    ///< bits of children that are nodes
    };
    struct Builder;

    static uint32_t estimate(const Node& node, const Vec3f& x, float near2, Lanes& weights);
    static double weigh(const Node& node, const Vec3f& x, Lanes& weights);

    std::vector<Node> nodes_;      // the root is the first
    std::vector<uint64_t> paths_;  // of each light: the child taken at the root in the lowest bits, and so on
    double totalIntensity_ = 0;
};

}  // namespace metrolux::core
