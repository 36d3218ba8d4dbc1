#pragma once
#include "base/distribution.h"
#include "endpoint/camera.h"
#include "endpoint/light.h"
#include "geometry/intersector.h"
#include "geometry/shape.h"
#include "image/filter.h"
#include "media/medium.h"
#include "scattering/bsdf.h"
#include "scene/scene_integrator.h"

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace metrolux::core {

class LightSelector;

/// Path-length limits of the scene's <integrator>.
struct PathLimits {
    int maxDepth =
        -1;  ///< largest number of path edges; -1: no limit. 1 sees lights only, 2 is direct light.
    int rouletteDepth = 5;      ///< edges of a subpath before roulette begins
    bool hideEmitters = false;  ///< directly visible lights are not shown
    /// Smallest number of path edges: integrators leave out what another pass of theirs finds.
    int minDepth = 1;

    bool admits(int edges) const { return edges >= minDepth && (maxDepth < 0 || edges <= maxDepth); }
};

/// What a loader makes: parts, before the scene is built.
struct SceneParts {
    std::vector<ShapePtr> shapes;  ///< with bsdf and emitter set
    std::vector<Instance> instances;
    std::vector<LightPtr> lights;  ///< all lights, area lights included
    std::vector<MediumPtr> media;  ///< what a MediumIndex refers to
    CameraPtr camera;
    PathLimits limits;
    SceneIntegrator integrator;
    ReconstructionFilter::Kind filterKind = ReconstructionFilter::Kind::Gaussian;
    ReconstructionFilter::Parameters filter;
    std::vector<std::string>
        warnings;        ///< what --lenient let pass, and what was understood but has no effect
    std::string source;  ///< file name
    /// Of the shapes, lights and camera, in the coordinates of the file: zero, unless the scene lies far from
    /// the file's origin.
    Vec3d origin{0.0};
};

/// What a scene may have instead of another one's, with which it shares the rest.
struct SceneView {
    CameraPtr camera;
    PathLimits limits;
    ReconstructionFilter::Kind filterKind = ReconstructionFilter::Kind::Gaussian;
    ReconstructionFilter::Parameters filter;
};

/// Immutable after construction.
class Scene {
  public:
    explicit Scene(SceneParts parts);
    /// The same shapes, materials and lights, with the intersector of `other`, seen another way. To the bit
    /// what its own parts with this view would make.
    Scene(const Scene& other, SceneView view);
    ~Scene();
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    bool intersect(const Ray& ray, SurfaceInteraction& si) const { return intersector_->intersect(ray, si); }
    /// Whether the segment between two surface points is free. The normals (zero when there is none) serve to
    /// move the ends off their surfaces.
    bool visible(const Vec3f& a, const Vec3f& ngA, const Vec3f& b, const Vec3f& ngB) const {
        return isFree(rayBetween(a, ngA, b, ngB));
    }
    /// Whether x sees infinity in direction w.
    bool visibleToInfinity(const Vec3f& x, const Vec3f& ng, const Vec3f& w) const {
        return isFree(rayToInfinity(x, ng, w));
    }
    /// The rays whose occlusion tells these; of length zero when the points coincide, which nothing is
    /// between.
    Ray rayBetween(const Vec3f& a, const Vec3f& ngA, const Vec3f& b, const Vec3f& ngB) const;
    Ray rayToInfinity(const Vec3f& x, const Vec3f& ng, const Vec3f& w) const {
        return {offsetRayOrigin(x, ng, w), w, kInfinity};
    }
    bool isFree(const Ray& ray) const { return !intersector_->occluded(ray); }

    const Intersector& intersector() const { return *intersector_; }
    const Camera& camera() const { return *parts_.camera; }
    const std::vector<LightPtr>& lights() const { return parts_.lights; }
    const Light* environment() const { return environment_; }
    const SceneParts& parts() const { return parts_; }
    const SceneBounds& bounds() const { return bounds_; }
    /// The lights of the scene emit 2^exponent times what they say, and images have to be multiplied by as
    /// much. 0 for ordinary scenes. A scene that is far brighter or darker is rendered at ordinary
    /// brightness: single precision and the fixed-point sums of the film hold it then, and emission times 2^k
    /// gives the image times 2^k to the bit.
    int emissionExponent() const { return emissionExponent_; }

    struct LightChoice {
        const Light* light = nullptr;
        float probability = 0;
        float emissionProbability = 0;  ///< as emissionProbability(light)
    };
    /// Whether there are any: what makes the passage through them stays out of scenes without.
    bool hasMedia() const { return !parts_.media.empty(); }
    /// Whether any surface scatters wavelengths differently: passes have none elsewhere.
    bool hasDispersion() const { return hasDispersion_; }
    /// Null for empty space.
    const Medium* medium(MediumIndex index) const {
        return index == 0 ? nullptr : parts_.media[index - 1].get();
    }
    /// What a vertex in a medium has as its shape.
    const Shape& mediumPoint(MediumIndex index) const { return *mediumPoints_[index - 1]; }
    MediumIndex cameraMedium() const { return cameraMedium_; }
    /// What a light subpath from that point of a light starts in.
    MediumIndex mediumOf(const Light& light, const EndpointRay& point) const;

    /// Picks a light for next-event estimation at x.
    LightChoice chooseLightForConnection(const Vec3f& x, float& u) const;
    float connectionProbability(const Vec3f& x, const Light* light) const;
    /// Picks a light that starts a light subpath.
    LightChoice chooseLightForEmission(float& u) const;
    float emissionProbability(const Light* light) const;

  private:
    void findBounds();
    void findBrightness();
    void chooseLights();
    void fillWithMedia();
    void findDispersion();
    void findMedia();
    MediumIndex mediumAt(const Vec3f& p) const;
    std::optional<MediumIndex> mediumSeen(const Vec3f& p, const Vec3f& direction) const;

    SceneParts parts_;
    std::shared_ptr<const Intersector> intersector_;
    SceneBounds bounds_;
    int emissionExponent_ = 0;
    bool hasDispersion_ = false;
    const Light* environment_ = nullptr;
    DiscreteDistribution emission_;
    std::shared_ptr<const LightSelector> connection_;
    std::unordered_map<const Light*, uint32_t> lightIndex_;
    std::vector<ShapePtr> mediumPoints_;
    std::vector<MediumIndex> lightMedia_;  ///< of lights that no boundary of a medium carries
    MediumIndex cameraMedium_ = 0;
    MediumIndex outerMedium_ = 0;  ///< around everything
};

}  // namespace metrolux::core
