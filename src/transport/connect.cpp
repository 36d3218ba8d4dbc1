#include "transport/connect.h"

#include "transport/walk.h"

namespace metrolux::core {

namespace {
EyeFinding weighHit(const Rgb& all, const EyeWeight& w, const MisState& mis) {
    return {all * static_cast<float>(w.weight), luminance(all) * static_cast<float>(w.alone), mis.smooth};
}
}  // namespace

EyeFinding hitLight(const Scene& scene, const Strategies& strategies, const Vertex& v) {
    const Light& light = *v.emitter();
    const Rgb radiance = light.radiance(v.si, v.toPrevious);
    if (isBlack(radiance)) return {};
    const Rgb all = strategies.seen(radiance * v.throughput, v.dispersed);
    if (v.depth == 1) return weighHit(all, {}, v.mis);

    const LightEdge edge = surfaceHitEdge(scene, v);
    return weighHit(all, hitWeight(strategies, v.mis, edge.pdfNeeAtLight(), edge.pdfEmission()), v.mis);
}

EyeFinding hitEnvironment(const Scene& scene, const Strategies& strategies, const Vec3f& from,
                          const WalkEdge& edge, int depth) {
    const Light* light = scene.environment();
    if (!light) return {};
    const Rgb radiance = light->environmentRadiance(edge.ray.direction);
    if (isBlack(radiance)) return {};
    const Rgb all = strategies.seen(radiance * edge.throughput, edge.dispersed);
    if (depth == 1) return weighHit(all, {}, edge.mis);

    const LightEdge last = environmentHitEdge(scene, *light, from, edge.ray.direction);
    return weighHit(all, hitWeight(strategies, edge.mis, last.pdfNeeAtLight(), last.pdfEmission()), edge.mis);
}

EyeFinding findLight(const Vertex& eye, const PendingConnection& pending, const Rgb& visibility) {
    return {throughEdge(pending.value, visibility), isBlack(visibility) ? 0.0f : pending.alone,
            eye.mis.smooth + 1};
}

namespace {
/// In scenes with media: what gets through to the other end of the shadow ray, which is known before the
/// weight, and nothing is left to ask for. False when nothing does.
bool passMedia(const Scene& scene, const Vertex& from, PendingConnection& pending, Passage& passage) {
    if (!scene.hasMedia()) return true;
    passage =
        passAlong(scene, pending.shadow, mediumBeyond(from, pending.shadow.direction), from.si.wavelength);
    pending.shadow.tMax = 0;
    return !passage.blocked();
}
}  // namespace

bool prepareLight(const Scene& scene, const Strategies& strategies, const Vertex& eye, float uLight,
                  const Vec2f& u, PendingConnection& pending) {
    const Scene::LightChoice choice = scene.chooseLightForConnection(eye.si.p, uLight);
    if (!choice.light) return false;
    const std::optional<EndpointConnection> c = choice.light->connect(eye.si.p, u);
    if (!c || isBlack(c->value)) return false;
    const VertexScattering s = scatterEye(eye, c->wi);
    if (isBlack(s.value)) return false;
    pending.shadow = choice.light->isInfinite() ? scene.rayToInfinity(eye.si.p, eye.si.ng, c->wi)
                                                : scene.rayBetween(eye.si.p, eye.si.ng, c->point, c->ng);
    LightEdge edge = neeEdge(choice, *c, eye);
    Rgb all = eye.throughput * s.value * c->value;
    Passage passage;
    if (!passMedia(scene, eye, pending, passage)) return false;
    if (scene.hasMedia()) {
        edge.arrival = passage.arrival(eye.stopDensity(c->wi));
        edge.arrivalAtLight = passage.arrival();
        all *= passage.transmittance;
    }
    all = strategies.seen(all, eye.dispersed || passage.dispersed);

    const EyeWeight weight = neeWeight(strategies, eye.mis, edge, s.pdfForward, s.pdfReverse);
    pending.value = all * static_cast<float>(weight.weight / choice.probability);
    pending.alone = luminance(all) * static_cast<float>(weight.alone / choice.probability);
    return true;
}

bool prepareCamera(const Scene& scene, const Strategies& strategies, const Vertex& light, const Vec2f& uLens,
                   Vec2f& raster, PendingConnection& pending) {
    const Camera& camera = scene.camera();
    const std::optional<EndpointConnection> c = camera.connect(light.si.p, uLens);
    if (!c) return false;
    const VertexScattering s = scatterLight(light, c->wi);
    if (isBlack(s.value)) return false;
    pending.shadow = scene.rayBetween(light.si.p, light.si.ng, c->point, c->ng);
    raster = c->filmPosition;

    const double cosine = light.cosine(c->wi);
    double pdfAreaFromEye =
        camera.isInfinite() ? c->pdfPosition * cosine : c->pdfDirection * cosine / sqr(double(c->distance));
    Passage passage;
    if (!passMedia(scene, light, pending, passage)) return false;
    if (scene.hasMedia()) pdfAreaFromEye *= passage.arrival(light.stopDensity(c->wi));
    const LightWeight weight = splatWeight(strategies, light.mis, strategies.regionOf(raster), pdfAreaFromEye,
                                           s.pdfReverse, light.inMedium);
    pending.value = light.throughput * s.value * c->value * static_cast<float>(weight.weight);
    if (scene.hasMedia()) pending.value *= passage.transmittance;
    pending.value = strategies.seen(pending.value, light.dispersed || passage.dispersed);
    pending.eye = weight.eye;
    return !isBlack(pending.value);
}

bool prepareVertices(const Scene& scene, const Strategies& strategies, const Vertex& light, const Vertex& eye,
                     PendingConnection& pending) {
    const Vec3f d = light.si.p - eye.si.p;
    const double distanceSquared = lengthSquared(d);
    if (!(distanceSquared > 0)) return false;
    const Vec3f toLight = d * static_cast<float>(1.0 / std::sqrt(distanceSquared));

    const VertexScattering e = scatterEye(eye, toLight);
    if (isBlack(e.value)) return false;
    const VertexScattering l = scatterLight(light, -toLight);
    if (isBlack(l.value)) return false;

    double pdfAreaFromEye = e.pdfForward * light.cosine(toLight) / distanceSquared;
    double pdfAreaFromLight = l.pdfForward * eye.cosine(toLight) / distanceSquared;
    pending.shadow = scene.rayBetween(eye.si.p, eye.si.ng, light.si.p, light.si.ng);
    Passage passage;
    if (!passMedia(scene, eye, pending, passage)) return false;
    if (scene.hasMedia()) {
        pdfAreaFromEye *= passage.arrival(light.stopDensity(toLight));
        pdfAreaFromLight *= passage.arrival(eye.stopDensity(toLight));
    }
    const LightWeight weight = connectWeight(strategies, light.mis, eye.mis, pdfAreaFromEye, pdfAreaFromLight,
                                             l.pdfReverse, e.pdfReverse);
    pending.value = light.throughput * l.value * eye.throughput * e.value *
                    static_cast<float>(weight.weight / distanceSquared);
    if (scene.hasMedia()) pending.value *= passage.transmittance;
    pending.value = strategies.seen(pending.value, light.dispersed || eye.dispersed || passage.dispersed);
    pending.eye = weight.eye;
    return !isBlack(pending.value);
}

namespace {
LightFinding findingOf(const Scene& scene, bool possible, const PendingConnection& pending) {
    if (!possible) return {};
    return {throughEdge(pending.value, visibility(scene, pending.shadow)), pending.eye};
}
}  // namespace

EyeFinding connectToLight(const Scene& scene, const Strategies& strategies, const Vertex& eye, float uLight,
                          const Vec2f& u) {
    PendingConnection pending;
    if (!prepareLight(scene, strategies, eye, uLight, u, pending)) return {};
    return findLight(eye, pending, visibility(scene, pending.shadow));
}

LightFinding connectToCamera(const Scene& scene, const Strategies& strategies, const Vertex& light,
                             const Vec2f& uLens, Vec2f& raster) {
    PendingConnection pending;
    return findingOf(scene, prepareCamera(scene, strategies, light, uLens, raster, pending), pending);
}

LightFinding connectVertices(const Scene& scene, const Strategies& strategies, const Vertex& light,
                             const Vertex& eye) {
    PendingConnection pending;
    return findingOf(scene, prepareVertices(scene, strategies, light, eye, pending), pending);
}

LightFinding mergeVertices(const Strategies& strategies, const Vertex& light, const Vertex& eye,
                           double inverseDiskArea) {
    constexpr float kMinimalNormalAgreement = 0.5f;
    if (dot(light.si.ng, eye.si.ng) < kMinimalNormalAgreement) return {};  // so too if one is in a medium
    // The density of photons on the surface is proportional to the cosine at the light vertex, S to that of
    // the shading normal: their ratio is the factor of [Veach97] for this vertex.
    const float cosineLight = light.cosine(light.toPrevious);
    if (!(cosineLight > 0)) return {};
    const VertexScattering s = scatterEye(eye, light.toPrevious);
    if (isBlack(s.value)) return {};
    const LightWeight weight = mergeWeight(strategies, light.mis, eye.mis, s.pdfForward, s.pdfReverse);
    const Rgb value = light.throughput * eye.throughput * s.value *
                      static_cast<float>(weight.weight * inverseDiskArea / cosineLight);
    return {strategies.seen(value, light.dispersed || eye.dispersed), weight.eye};
}

LightFinding mergeInMedium(const Strategies& strategies, const Vertex& light, const Vertex& eye,
                           double inverseVolume) {
    if (!eye.inMedium || light.medium != eye.medium) return {};
    const VertexScattering s = scatterEye(eye, light.toPrevious);
    if (isBlack(s.value)) return {};
    const LightWeight weight = mergeWeight(strategies, light.mis, eye.mis, s.pdfForward, s.pdfReverse);
    const Rgb value =
        light.throughput * eye.throughput * s.value * static_cast<float>(weight.weight * inverseVolume);
    return {strategies.seen(value, light.dispersed || eye.dispersed), weight.eye};
}

}  // namespace metrolux::core
