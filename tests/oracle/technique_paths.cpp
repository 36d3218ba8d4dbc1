#include "oracle/technique_paths.h"

#include "sampling/streams.h"
#include "transport/connect.h"

namespace metrolux::core::test {

namespace {

/// Vertices of a subpath that techniques are tried at.
constexpr size_t kVertices = 3;

/// With these counts and no history every other technique vanishes from the weight of a connection or merge:
/// what remains is the contribution itself.
const Strategies kConnectionsAlone = Strategies::bidirectional(1e-30, 0);
const Strategies kMergesAlone = Strategies::bidirectional(1e-30, 1e30);

Vertex withoutHistory(Vertex v) {
    v.mis = {};
    return v;
}

double ratio(const Rgb& a, const Rgb& b) {
    return luminance(b) > 0 ? double(luminance(a)) / luminance(b) : -1;
}

}  // namespace

void TechniquePaths::run(uint64_t index) {
    IndependentStream eyeStream(hashKey(index, 1)), lightStream(hashKey(index, 2));
    rng_ = CounterRng(hashKey(index, 3));
    choices_ = CounterRng(hashKey(index, 5));
    eye_ = {};
    light_ = {};
    const PathLimits& limits = scene_.parts().limits;
    const FilmWindow& window = scene_.camera().window();
    const float x = rng_.next1D() * kImageWidth, y = rng_.next1D() * kImageHeight;
    raster_ = {static_cast<float>(window.x) + x, static_cast<float>(window.y) + y};
    traceEyeSubpath(scene_, eyeStream, limits, n_, raster_, 1, 0, eye_);
    eyeStream.seek(0);
    eyeStream.next2D();
    uLens_ = eyeStream.next2D();
    traceLightSubpath(scene_, lightStream, limits, n_, light_);
    lightStream.seek(0);
    float uLight = lightStream.next1D();
    source_ = scene_.chooseLightForEmission(uLight).light;
    for (const Vertex& v : eye_.vertices) reducedShares_ += v.mis.mergeShare < 0.9f;

    if (wanted_("hit")) hits();
    nextEvents();
    splats();
    if (wanted_("connect")) connections();
    merges();
}

void TechniquePaths::setLight(FullPath& path, const Light* light, const Vertex& first) const {
    path.light = light;
    path.toLight = first.toPrevious;
    path.lightPosition = first.si.p + first.toPrevious * first.distanceToPrevious;
    if (light->isInfinite() || light->isDelta()) return;
    // A point on a sphere's silhouette may be missed by the rounded ray: such a path is left out.
    Ray ray{offsetRayOrigin(first.si.p, first.si.ng, first.toPrevious), first.toPrevious, kInfinity};
    path.found = scene_.intersect(ray, path.lightPoint);
    while (oracle_.media.present && path.found && path.lightPoint.shape->bsdf->hasNullLobe()) {
        ray.origin = offsetRayOrigin(path.lightPoint.p, path.lightPoint.ng, ray.direction);
        path.found = scene_.intersect(ray, path.lightPoint);
    }
    path.found = path.found && path.lightPoint.shape->emitter.get() == light;
    path.lightPosition = path.lightPoint.p;
}

void TechniquePaths::appendLight(FullPath& path, size_t count) const {
    setLight(path, source_, light_.vertices[0]);
    for (size_t j = 0; j < count; ++j)
        path.inner.push_back({light_.vertices[j].si, j + 1 < count && light_.deltas[j]});
}

void TechniquePaths::appendEye(FullPath& path, size_t count, bool smoothEnd) const {
    path.uLens = uLens_;
    path.raster = count > 0 ? raster_ : joinedRaster_;
    for (size_t j = count; j-- > 0;)
        path.inner.push_back({eye_.vertices[j].si, !(smoothEnd && j + 1 == count) && eye_.deltas[j]});
}

void TechniquePaths::hits() {
    const std::vector<Vertex>& e = eye_.vertices;
    const Light* environment = scene_.environment();
    if (environment && eye_.ended && !e.empty()) {
        const WalkEdge& edge = eye_.escape;
        FullPath path;
        path.light = environment;
        path.toLight = edge.ray.direction;
        appendEye(path, e.size(), false);
        const Rgb all = environment->environmentRadiance(path.toLight) * edge.throughput;
        if (!isBlack(all))
            check_({"hit", 0}, path,
                   ratio(hitEnvironment(scene_, n_, eye_.escapeFrom, edge, eye_.escapeDepth).value, all));
    }
    for (size_t j = 1; j < e.size(); ++j) {
        const Light* light = e[j].si.shape->emitter.get();
        if (!light) continue;
        const Rgb all = light->radiance(e[j].si, e[j].toPrevious) * e[j].throughput;
        if (isBlack(all)) continue;
        FullPath path;
        path.light = light;
        path.lightPoint = e[j].si;
        path.lightPosition = e[j].si.p;
        appendEye(path, j, false);
        check_({"hit", 0}, path, ratio(hitLight(scene_, n_, e[j]).value, all));
    }
}

void TechniquePaths::nextEvents() {
    const std::vector<Vertex>& e = eye_.vertices;
    for (size_t j = 0; j < e.size() && j < kVertices && wanted_("nee"); ++j) {
        if (!e[j].hasSmoothLobe()) continue;
        const Vec2f u = rng_.next2D();
        const float uLight = choices_.next1D();
        float uChoice = uLight;
        const Scene::LightChoice choice = scene_.chooseLightForConnection(e[j].si.p, uChoice);
        if (!choice.light) continue;
        const Rgb weighted = connectToLight(scene_, n_, e[j], uLight, u).value;
        const auto c = choice.light->connect(e[j].si.p, u);
        if (isBlack(weighted) || !c) continue;
        const Rgb all =
            e[j].throughput * scatterEye(e[j], c->wi).value * c->value * (1.0f / choice.probability);
        FullPath path;
        Vertex first = e[j];
        first.toPrevious = c->wi;
        first.distanceToPrevious = c->distance;
        setLight(path, choice.light, first);
        appendEye(path, j + 1, true);
        const Ray toInfinity = scene_.rayToInfinity(e[j].si.p, e[j].si.ng, c->wi);
        const Passage passage = choice.light->isInfinite()
                                    ? passAlong(scene_, toInfinity, mediumBeyond(e[j], c->wi))
                                    : passageFrom(e[j], c->point, c->ng);
        check_({"nee", 1}, path, ratio(weighted, all * passage.transmittance));
    }
}

void TechniquePaths::splats() {
    const std::vector<Vertex>& l = light_.vertices;
    for (size_t j = 0; j < l.size() && j < kVertices && wanted_("splat"); ++j) {
        if (!l[j].hasSmoothLobe()) continue;
        FullPath path;
        path.uLens = choices_.next2D();
        Vec2f raster;
        const Rgb weighted = connectToCamera(scene_, n_, l[j], path.uLens, raster).value;
        if (isBlack(weighted)) continue;
        path.raster = raster;
        appendLight(path, j + 1);
        check_(
            {"splat", static_cast<int>(j) + 2}, path,
            ratio(
                weighted,
                connectToCamera(scene_, kConnectionsAlone, withoutHistory(l[j]), path.uLens, raster).value));
    }
}

void TechniquePaths::connections() {
    const std::vector<Vertex>&l = light_.vertices, &e = eye_.vertices;
    for (size_t a = 0; a < l.size() && a < kVertices; ++a)
        for (size_t b = 0; b < e.size() && b < kVertices && wanted_("connect"); ++b) {
            if (!l[a].hasSmoothLobe() || !e[b].hasSmoothLobe()) continue;
            const Rgb weighted = connectVertices(scene_, n_, l[a], e[b]).value;
            if (isBlack(weighted) || !(lengthSquared(l[a].si.p - e[b].si.p) > 1e-4f)) continue;
            FullPath path;
            appendLight(path, a + 1);
            appendEye(path, b + 1, true);
            const Rgb all =
                connectVertices(scene_, kConnectionsAlone, withoutHistory(l[a]), withoutHistory(e[b])).value;
            check_({"connect", static_cast<int>(a) + 2}, path, ratio(weighted, all));
        }
}

void TechniquePaths::merges() {
    const std::vector<Vertex>& l = light_.vertices;
    for (size_t a = 0; a < l.size() && a < kVertices && wanted_("merge"); ++a) {
        if (!l[a].hasSmoothLobe()) continue;
        const size_t b = static_cast<size_t>(rng_.next1D() * (static_cast<float>(kVertices) - 0.001f));
        const std::optional<Vertex> joined = joinedVertex(a, b);
        if (!joined) continue;
        const auto merge = l[a].inMedium ? mergeInMedium : mergeVertices;
        const Rgb weighted = merge(n_, l[a], *joined, 1).value;
        if (isBlack(weighted)) continue;
        FullPath path;
        appendLight(path, a + 1);
        appendEye(path, b, true);
        check_({"merge", static_cast<int>(a) + 1}, path,
               ratio(weighted, merge(kMergesAlone, withoutHistory(l[a]), withoutHistory(*joined), 1).value));
    }
}

Passage TechniquePaths::passageFrom(const Vertex& v, const Vec3f& p, const Vec3f& ng) const {
    const Ray ray = scene_.rayBetween(v.si.p, v.si.ng, p, ng);
    // Without media null lobes are events of a path, and surfaces that have them are in the way.
    if (!scene_.hasMedia()) return scene_.isFree(ray) ? Passage{} : Passage{Rgb(0.0f), Rgb(0.0f)};
    return passAlong(scene_, ray, mediumBeyond(v, ray.direction));
}

std::optional<Vertex> TechniquePaths::joinedVertex(size_t a, size_t b) {
    const Vertex& at = light_.vertices[a];
    const std::vector<Vertex>& e = eye_.vertices;
    if (b > e.size() || (b > 0 && !e[b - 1].hasSmoothLobe())) return std::nullopt;
    Vertex joined = at;
    joined.throughput = Rgb(1.0f);
    double distanceSquared = 1, cosine = 0;
    Passage passage;
    Rgb atStart(1.0f);
    if (b == 0) {
        const auto c = scene_.camera().connect(at.si.p, uLens_);
        if (!c) return std::nullopt;
        passage = passageFrom(at, c->point, c->ng);
        if (passage.blocked()) return std::nullopt;
        joined.toPrevious = c->wi;
        joined.distanceToPrevious = c->distance;
        const bool infinite = scene_.camera().isInfinite();
        if (!infinite) distanceSquared = sqr(double(c->distance));
        joinedRaster_ = c->filmPosition;
        joined.mis =
            MisState::startEye(n_, infinite ? c->pdfPosition : c->pdfDirection, n_.regionOf(joinedRaster_));
    } else {
        const Vertex& from = e[b - 1];
        passage = passageFrom(at, from.si.p, from.si.ng);
        if (passage.blocked()) return std::nullopt;
        joined.toPrevious = normalize(from.si.p - at.si.p);
        joined.distanceToPrevious = (from.si.p - at.si.p).length();
        distanceSquared = sqr(double(joined.distanceToPrevious));
        const VertexScattering s = scatterEye(from, -joined.toPrevious);
        if (!(s.pdfForward > 0)) return std::nullopt;
        joined.mis = from.mis;
        joined.mis.scatter(n_, from.cosine(joined.toPrevious), s.pdfForward, s.pdfReverse);
        joined.mis.mergeShare = static_cast<float>(n_.mergeShare(joined.si.p));
        atStart = from.stopDensity(joined.toPrevious);
    }
    if (joined.inMedium) joined.mis.mergeShare = static_cast<float>(n_.mergeInMedia);
    cosine = joined.cosine(joined.toPrevious);
    if (!(cosine > 1e-4) || !(distanceSquared > 1e-4)) return std::nullopt;
    joined.mis.arrive(distanceSquared, cosine);
    joined.mis.pass(passage.arrival(joined.stopDensity(joined.toPrevious)), passage.arrival(atStart));
    return joined;
}

}  // namespace metrolux::core::test
