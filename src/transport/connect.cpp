#include "transport/connect.h"

#include "transport/walk.h"

namespace metrolux::core {

Rgb hitLight(const Scene& scene, const Strategies& strategies, const Vertex& v) {
    const Light& light = *v.emitter();
    const Rgb radiance = light.radiance(v.si, v.toPrevious);
    if (isBlack(radiance)) return Rgb(0.0f);
    if (v.depth == 1) return radiance * v.throughput;

    const LightEdge edge = surfaceHitEdge(scene, v);
    return radiance * v.throughput *
           static_cast<float>(hitWeight(strategies, v.mis, edge.pdfNeeAtLight(), edge.pdfEmission()));
}

Rgb hitEnvironment(const Scene& scene, const Strategies& strategies, const Vec3f& from,
                   const Vec3f& direction, const Rgb& throughput, const MisState& mis, int depth) {
    const Light* light = scene.environment();
    if (!light) return Rgb(0.0f);
    const Rgb radiance = light->environmentRadiance(direction);
    if (isBlack(radiance)) return Rgb(0.0f);
    if (depth == 1) return radiance * throughput;

    const LightEdge edge = environmentHitEdge(scene, *light, from, direction);
    return radiance * throughput *
           static_cast<float>(hitWeight(strategies, mis, edge.pdfNeeAtLight(), edge.pdfEmission()));
}

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

    const double weight =
        neeWeight(strategies, eye.mis, neeEdge(choice, *c, eye), s.pdfForward, s.pdfReverse);
    pending.value = eye.throughput * s.value * c->value * static_cast<float>(weight / choice.probability);
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
    const double pdfAreaFromEye =
        camera.isInfinite() ? c->pdfPosition * cosine : c->pdfDirection * cosine / sqr(double(c->distance));
    const double weight = splatWeight(strategies, light.mis, pdfAreaFromEye, s.pdfReverse);
    pending.value = light.throughput * s.value * c->value * static_cast<float>(weight);
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

    const double pdfAreaFromEye = e.pdfForward * light.cosine(toLight) / distanceSquared;
    const double pdfAreaFromLight = l.pdfForward * eye.cosine(toLight) / distanceSquared;
    const double weight = connectWeight(strategies, light.mis, eye.mis, pdfAreaFromEye, pdfAreaFromLight,
                                        l.pdfReverse, e.pdfReverse);
    pending.value =
        light.throughput * l.value * eye.throughput * e.value * static_cast<float>(weight / distanceSquared);
    if (isBlack(pending.value)) return false;
    pending.shadow = scene.rayBetween(eye.si.p, eye.si.ng, light.si.p, light.si.ng);
    return true;
}

namespace {
Rgb valueOf(const Scene& scene, bool possible, const PendingConnection& pending) {
    return possible ? throughEdge(pending.value, visibility(scene, pending.shadow)) : Rgb(0.0f);
}
}  // namespace

Rgb connectToLight(const Scene& scene, const Strategies& strategies, const Vertex& eye, float uLight,
                   const Vec2f& u) {
    PendingConnection pending;
    return valueOf(scene, prepareLight(scene, strategies, eye, uLight, u, pending), pending);
}

Rgb connectToCamera(const Scene& scene, const Strategies& strategies, const Vertex& light, const Vec2f& uLens,
                    Vec2f& raster) {
    PendingConnection pending;
    return valueOf(scene, prepareCamera(scene, strategies, light, uLens, raster, pending), pending);
}

Rgb connectVertices(const Scene& scene, const Strategies& strategies, const Vertex& light,
                    const Vertex& eye) {
    PendingConnection pending;
    return valueOf(scene, prepareVertices(scene, strategies, light, eye, pending), pending);
}

Rgb mergeVertices(const Strategies& strategies, const Vertex& light, const Vertex& eye,
                  double inverseDiskArea) {
    constexpr float kMinimalNormalAgreement = 0.5f;
    if (dot(light.si.ng, eye.si.ng) < kMinimalNormalAgreement) return Rgb(0.0f);
    // The density of photons on the surface is proportional to the cosine at the light vertex, S to that of
    // the shading normal: their ratio is the factor of [Veach97] for this vertex.
    const float cosineLight = light.cosine(light.toPrevious);
    if (!(cosineLight > 0)) return Rgb(0.0f);
    const VertexScattering s = scatterEye(eye, light.toPrevious);
    if (isBlack(s.value)) return Rgb(0.0f);
    const double weight = mergeWeight(strategies, light.mis, eye.mis, s.pdfForward, s.pdfReverse);
    return light.throughput * eye.throughput * s.value *
           static_cast<float>(weight * inverseDiskArea / cosineLight);
}

}  // namespace metrolux::core
