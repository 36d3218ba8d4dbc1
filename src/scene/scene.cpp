#include "scene/scene.h"

#include "base/error.h"
#include "scene/light_selector.h"

#include <cmath>
#include <numbers>

namespace metrolux::core {

namespace {

/// Shadow rays end this fraction before their target, beyond what offsetRayOrigin moves the ends.
constexpr float kShadowEpsilon = 1e-5f;

}  // namespace

Scene::Scene(SceneParts parts) : parts_(std::move(parts)) {
    if (!parts_.camera) throw Error("{}: the scene has no sensor", parts_.source);
    try {
        intersector_ = std::make_shared<const Intersector>(parts_.shapes, parts_.instances);
    } catch (const Error& error) {
        throw Error("{}: {}", parts_.source, error.what());
    }
    findBounds();
    for (const LightPtr& light : parts_.lights) light->setSceneBounds(bounds_);
    findBrightness();
    chooseLights();
    fillWithMedia();
    findMedia();
    findDispersion();
}

Scene::Scene(const Scene& other, SceneView view)
    : parts_(other.parts_),
      intersector_(other.intersector_),
      emissionExponent_(other.emissionExponent_),
      hasDispersion_(other.hasDispersion_) {
    parts_.camera = std::move(view.camera);
    parts_.limits = view.limits;
    parts_.filterKind = view.filterKind;
    parts_.filter = view.filter;
    mediumPoints_ = other.mediumPoints_;
    findBounds();
    findMedia();
    if (bounds_ == other.bounds_) {
        environment_ = other.environment_;
        emission_ = other.emission_;
        connection_ = other.connection_;
        lightIndex_ = other.lightIndex_;
        return;
    }
    // Infinite lights know the bounds, and those of `other` keep theirs. No shape refers to them.
    for (LightPtr& light : parts_.lights) {
        if (!light->isInfinite()) continue;
        light = light->copy();
        light->setSceneBounds(bounds_);
    }
    chooseLights();
}

void Scene::findDispersion() {
    const auto isDispersive = [](const ShapePtr& shape) {
        return shape->bsdf && shape->bsdf->isDispersive();
    };
    const auto any = [&](const std::vector<ShapePtr>& shapes) {
        return std::any_of(shapes.begin(), shapes.end(), isDispersive);
    };
    hasDispersion_ = any(parts_.shapes) ||
                     std::any_of(parts_.instances.begin(), parts_.instances.end(),
                                 [&](const Instance& instance) { return any(instance.group->shapes); });
}

/// All surfaces and the camera.
void Scene::findBounds() {
    Vec3f lower, upper;
    intersector_->bounds(lower, upper);
    const Vec3f eye = parts_.camera->position();
    for (int axis = 0; axis < 3; ++axis) {
        if (!std::isfinite(lower[axis]) || !std::isfinite(upper[axis])) lower[axis] = upper[axis] = eye[axis];
        lower[axis] = std::min(lower[axis], eye[axis]);
        upper[axis] = std::max(upper[axis], eye[axis]);
    }
    bounds_.center = (lower + upper) * 0.5f;
    bounds_.radius = std::max((upper - lower).length() * 0.5f, 1e-6f) * 1.001f;
}

namespace {

/// A radiance: that of a constant environment, or what an environment would have that sends as much power to
/// the shapes. The camera's place makes no difference, so that views of a scene agree.
double brightness(const std::vector<LightPtr>& lights, double radiusWithCamera, const Intersector& shapes) {
    Vec3f lower, upper;
    shapes.bounds(lower, upper);
    const double radius = 0.5 * double((upper - lower).length());
    const auto etendue = [](double r) { return 4 * sqr(std::numbers::pi * r); };
    double sum = 0;
    for (const LightPtr& light : lights)
        sum += double(light->power()) / etendue(light->isInfinite() ? radiusWithCamera
                                                : radius > 0        ? radius
                                                                    : 1.0);
    return sum;
}

}  // namespace

/// The lights know the bounds.
void Scene::findBrightness() {
    constexpr int kOrdinary = 20, kFar = 96;
    const std::vector<LightPtr>& lights = parts_.lights;
    if (lights.empty()) return;
    // Lights that another scene shares keep what it has given them.
    emissionExponent_ = lights.front()->emissionExponent();
    if (emissionExponent_ != 0) return;
    const auto brightnessAt = [&](int exponent) {
        for (const LightPtr& light : lights) light->setEmissionExponent(exponent);
        return brightness(lights, bounds_.radius, *intersector_);
    };
    // Where powers leave the range of single precision, they are looked at from the other end of it.
    int exponent = 0;
    double b = brightnessAt(0);
    if (!std::isfinite(b))
        b = brightnessAt(exponent = kFar);
    else if (b < 0x1p-64)
        b = brightnessAt(exponent = -kFar);
    if (b > 0 && std::isfinite(b)) exponent += std::ilogb(b);
    if (!(b > 0) || !std::isfinite(b) || std::abs(exponent) <= kOrdinary) exponent = 0;
    brightnessAt(exponent);
    emissionExponent_ = exponent;
}

/// The lights know the bounds.
void Scene::chooseLights() {
    std::vector<double> powers;
    for (const LightPtr& light : parts_.lights) {
        if (light->isEnvironment()) {
            if (environment_) throw Error("{}: more than one environment emitter", parts_.source);
            environment_ = light.get();
        }
        lightIndex_.emplace(light.get(), static_cast<uint32_t>(powers.size()));
        powers.push_back(light->power());
        if (!std::isfinite(powers.back()))
            throw Error(
                "{}: the power of light {} of {} is {}, expected a finite number: is its emission or its "
                "size beyond what single precision holds?",
                parts_.source, powers.size(), parts_.lights.size(), powers.back());
    }
    if (!powers.empty()) emission_ = DiscreteDistribution(mixedWithEven(powers, 0.1));
    try {
        connection_ = std::make_shared<const LightSelector>(parts_.lights, bounds_);
    } catch (const Error& error) {
        throw Error("{}: {}", parts_.source, error.what());
    }
}

Scene::~Scene() = default;

Ray Scene::rayBetween(const Vec3f& a, const Vec3f& ngA, const Vec3f& b, const Vec3f& ngB) const {
    const Vec3f rough = b - a;
    const Vec3f from = ngA == Vec3f(0.0f) ? a : offsetRayOrigin(a, ngA, rough);
    const Vec3f to = ngB == Vec3f(0.0f) ? b : offsetRayOrigin(b, ngB, -rough);
    const Vec3f d = to - from;
    const float distance = d.length();
    if (!(distance > 0)) return {from, Vec3f(0, 0, 1), 0};
    return {from, d * (1.0f / distance), distance * (1.0f - kShadowEpsilon)};
}

Scene::LightChoice Scene::chooseLightForConnection(const Vec3f& x, float& u) const {
    if (connection_->empty()) return {};
    const LightSelector::Choice choice = connection_->sample(x, u);
    return {parts_.lights[choice.light].get(), choice.probability,
            static_cast<float>(emission_.pmf(choice.light))};
}

float Scene::connectionProbability(const Vec3f& x, const Light* light) const {
    return connection_->probability(x, lightIndex_.at(light));
}

Scene::LightChoice Scene::chooseLightForEmission(float& u) const {
    if (parts_.lights.empty()) return {};
    const size_t i = emission_.sample(u);
    const auto probability = static_cast<float>(emission_.pmf(i));
    return {parts_.lights[i].get(), probability, probability};
}

float Scene::emissionProbability(const Light* light) const {
    return static_cast<float>(emission_.pmf(lightIndex_.at(light)));
}

}  // namespace metrolux::core
