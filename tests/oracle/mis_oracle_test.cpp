/// Recursive MIS weights against brute force: for random paths of every technique, the weight that transport/
/// applies is compared with one made of the products of all densities along the path
/// (docs/explain/algorithm.md section 1), and the weights of all techniques of one path must sum to one.
/// Deterministic: fixed seeds. 99.9 % of the paths must agree to 1e-4 (relative) and all to 2e-3 (8e-3 where
/// a quarter of the light subpaths is connected): vertices are single precision, and refraction magnifies the
/// rounding of a few. A wrong cosine, count or index of refraction shows as deviations of 1e-2 to 1 in most
/// paths.

#include "sampling/streams.h"
#include "scattering/fresnel.h"
#include "support/small_scenes.h"
#include "transport/connect.h"
#include "transport/subpath.h"

#include <gtest/gtest.h>

#include <map>

namespace metrolux::core {
namespace {

using test::SceneBuilder;

constexpr float kGlassEta = 1.5f;

enum class Lighting { Area, SphereArea, Point, Directional, Constant };

std::shared_ptr<Scene> makeScene(Lighting lighting) {
    SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.7f));
    RoughConductorParameters metal;
    metal.alphaU = metal.alphaV = test::constant(Rgb(0.5f));
    b.add(test::rectangle({0, 2, -3}, {0, 0, 1}, 4, 3), makeRoughConductor(metal));
    DielectricParameters glass;
    glass.eta = kGlassEta;
    b.add(makeSphere(Transform(), {0.3f, 1.2f, 0}, 0.6f, false), makeDielectric(glass));
    // Water above a part of the floor: an odd number of refractions, so that wrong factors do not cancel.
    b.add(test::rectangle({3, 0.4f, 0}, {0, 1, 0}, 2, 4), makeDielectric(glass));
    b.add(makeSphere(Transform(), {-1.2f, 0.6f, 0.5f}, 0.5f, false), test::diffuse(0.5f));
    switch (lighting) {
        case Lighting::Area:
            b.emit(b.add(test::rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), test::diffuse(0.3f)), Rgb(5));
            break;
        case Lighting::SphereArea:
            b.emit(b.add(makeSphere(Transform(), {0.5f, 3, 0}, 0.5f, false), test::diffuse(0.3f)), Rgb(5));
            break;
        case Lighting::Point: {
            PointLightParameters p;
            p.position = {0.5f, 3, 0.2f};
            b.light(makePointLight(p));
            break;
        }
        case Lighting::Directional: {
            DirectionalLightParameters p;
            p.direction = normalize(Vec3f(0.2f, -1, -0.1f));
            b.light(makeDirectionalLight(p));
            break;
        }
        case Lighting::Constant:
            b.light(makeConstantLight({}));
            break;
    }
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 32, 24);
    b.limits().maxDepth = 9;
    b.limits().rouletteDepth = 100;
    return b.build();
}

/// A full path, light to camera: x[0] is the light (or a direction to infinity), x.back() the camera's
/// neighbor.
struct FullPath {
    const Light* light = nullptr;
    bool infinite = false;
    bool found = true;
    Vec3f toLight{0.0f};            ///< infinite lights: direction from x1
    SurfaceInteraction lightPoint;  ///< area lights
    Vec3f lightPosition{0.0f};
    std::vector<SurfaceInteraction> inner;  ///< x1 ... x_{k-1}
};

Vec3f directionBetween(const Vec3f& a, const Vec3f& b) { return normalize(b - a); }

/// |d w_out / d w_in| of refraction at a plane interface by finite differences.
double refractionJacobian(const Vec3f& wIn, const Vec3f& normal, double etaInOverOut) {
    using V = Imath::V3d;
    const V n = V(normal) * (dot(wIn, normal) > 0 ? 1.0 : -1.0);
    const auto refract = [&](const V& w) {
        const double c = w.dot(n);
        const V tangential = (w - n * c) * -etaInOverOut;
        return tangential - n * std::sqrt(std::max(0.0, 1.0 - tangential.dot(tangential)));
    };
    const Frame f = Frame::fromNormal(wIn);
    const double h = 1e-5;
    const V w(wIn), s(f.s), t(f.t);
    const V ds = (refract((w + s * h).normalized()) - refract((w - s * h).normalized())) / (2 * h);
    const V dt = (refract((w + t * h).normalized()) - refract((w - t * h).normalized())) / (2 * h);
    return ds.cross(dt).length();
}

class BruteForce {
  public:
    BruteForce(const Scene& scene, const Strategies& n) : scene_(scene), n_(n) {}

    /// Weights of all techniques, keyed by (name, s).
    std::map<std::pair<std::string, int>, double> weights(const FullPath& path) const {
        const int m = static_cast<int>(path.inner.size());  // inner vertices; the camera is x_{m+1}
        const auto p = [&](int i) -> const SurfaceInteraction& { return path.inner[i - 1]; };
        const Vec3f eye = scene_.camera().position();
        const auto towardLight = [&](int i) {
            return i == 1 ? (path.infinite ? path.toLight : directionBetween(p(1).p, path.lightPosition))
                          : directionBetween(p(i).p, p(i - 1).p);
        };
        const auto towardEye = [&](int i) { return directionBetween(p(i).p, i == m ? eye : p(i + 1).p); };
        const auto smooth = [&](int i) { return p(i).shape->bsdf->hasSmoothLobe(); };

        // Densities per area of x_i: forward[i] from the light side, backward[i] from the camera side.
        std::vector<double> forward(m + 1), backward(m + 1);
        const EndpointDensities d = densities(path);
        const double cosineLight =
            path.infinite || path.light->isDelta() ? 1.0 : absDot(towardLight(1), path.lightPoint.ng);
        const double d2 = path.infinite ? 1.0 : lengthSquared(p(1).p - path.lightPosition);
        forward[0] = d.pdfPosition * scene_.emissionProbability(path.light);
        if (path.infinite) forward[0] = d.pdfDirection * scene_.emissionProbability(path.light);
        forward[1] = (path.infinite ? d.pdfPosition : d.pdfDirection / d2) * absDot(towardLight(1), p(1).ng);
        double nee0 = scene_.connectionProbability(p(1).p, path.light);
        if (!path.light->isDelta()) nee0 *= d.connect * (path.infinite ? 1.0 : cosineLight / d2);

        for (int i = 1; i < m; ++i)
            forward[i + 1] = scatterDensity(p(i), towardLight(i), towardEye(i), true) *
                             absDot(towardEye(i), p(i + 1).ng) / lengthSquared(p(i + 1).p - p(i).p);
        for (int i = m; i >= 1; --i) {
            const double pdf = scatterDensity(p(i), towardLight(i), towardEye(i), false);
            if (i > 1)
                backward[i - 1] =
                    pdf * absDot(towardLight(i), p(i - 1).ng) / lengthSquared(p(i - 1).p - p(i).p);
            else
                backward[0] = path.infinite ? pdf : pdf * cosineLight / d2;
        }
        const auto c = scene_.camera().connect(p(m).p, Vec2f(0.5f));
        backward[m] = c->pdfDirection * absDot(towardEye(m), p(m).ng) / lengthSquared(p(m).p - eye);

        const auto product = [&](int s) {  // P_s over x_0 ... x_m
            double value = 1;
            for (int i = 0; i < s; ++i) value *= forward[i];
            for (int i = s; i <= m; ++i) value *= backward[i];
            return value;
        };
        std::map<std::pair<std::string, int>, double> density;
        if (!path.light->isDelta()) density[{"hit", 0}] = n_.hitNee * product(0);
        if (smooth(1)) density[{"nee", 1}] = n_.hitNee * nee0 * product(0) / backward[0];
        for (int s = 2; s <= m; ++s)
            if (smooth(s - 1) && smooth(s)) density[{"connect", s}] = n_.connect * product(s);
        if (m >= 1 && smooth(m)) density[{"splat", m + 1}] = n_.splat * product(m + 1);
        if (n_.merge > 0) {
            bool certain = true;  // only delta scattering between x_s and the camera
            for (int s = m; s >= 1; --s) {
                if (!smooth(s)) continue;
                density[{"merge", s}] =
                    n_.merge * product(s) * forward[s] * (certain ? 1.0 : n_.mergeShare(p(s).p));
                certain = false;
            }
        }
        double sum = 0;
        for (const auto& [key, value] : density) sum += value;
        for (auto& [key, value] : density) value /= sum;
        return density;
    }

    /// The oracle takes directions from differences of float positions: short edges, grazing directions and
    /// densities that change quickly (refraction near total reflection) would test float rounding, not the
    /// recursion.
    bool wellConditioned(const FullPath& path) const {
        const int m = static_cast<int>(path.inner.size());
        for (int i = 0; i <= m; ++i) {
            if (i == 0 && path.infinite) continue;
            const Vec3f a = i == 0 ? path.lightPosition : path.inner[i - 1].p;
            const Vec3f b = i == m ? scene_.camera().position() : path.inner[i].p;
            const Vec3f d = b - a;
            if (d.length() < 0.3f) return false;
            const Vec3f w = normalize(d);
            if (i == 0 && !path.light->isDelta() && absDot(w, path.lightPoint.ng) < 0.2f) return false;
            if (i > 0 && grazing(path.inner[i - 1], w)) return false;
            if (i < m && grazing(path.inner[i], w)) return false;
        }
        return true;
    }

  private:
    static bool grazing(const SurfaceInteraction& si, const Vec3f& w) {
        return absDot(w, si.ng) < (si.shape->bsdf->hasSmoothLobe() ? 0.2f : 0.4f);
    }

    EndpointDensities densities(const FullPath& path) const {
        if (path.infinite && !path.light->isDelta())
            return path.light->environmentDensities(path.inner[0].p, path.toLight);
        if (!path.light->isDelta()) return path.light->densities(path.inner[0].p, path.lightPoint);
        const auto c = path.light->connect(path.inner[0].p, Vec2f(0.5f));
        EndpointDensities d;
        d.pdfPosition = c->pdfPosition;
        d.pdfDirection = c->pdfDirection;
        return d;
    }

    /// Density of the direction to the eye (forward) or to the light, per solid angle. Delta lobes: their
    /// probability, in the measure of the eye-side direction.
    double scatterDensity(const SurfaceInteraction& si, const Vec3f& wLight, const Vec3f& wEye,
                          bool forward) const {
        const Bsdf& bsdf = *si.shape->bsdf;
        if (bsdf.hasSmoothLobe()) {
            const BsdfEvaluation e = bsdf.evaluate(si, si.toLocal(wEye), si.toLocal(wLight));
            return forward ? e.pdfEye : e.pdfLight;
        }
        const double cl = dot(wLight, si.ns), ce = dot(wEye, si.ns);
        const double known = forward ? cl : ce;
        const double reflectance = fresnelDielectric(static_cast<float>(known), kGlassEta);
        if (cl * ce > 0) return reflectance;
        const double probability = 1 - reflectance;
        if (forward) return probability;
        return probability * refractionJacobian(wLight, si.ns, cl > 0 ? 1 / kGlassEta : kGlassEta);
    }

    const Scene& scene_;
    const Strategies& n_;
};

class Collector final : public SubpathVisitor {
  public:
    std::vector<Vertex> vertices;
    bool ended = false;
    Vec3f escapeFrom{0.0f}, escapeDirection{0.0f};
    Rgb escapeThroughput{0.0f};
    MisState escapeMis;
    int escapeDepth = 0;
    bool surface(const Vertex& v) override {
        vertices.push_back(v);
        return true;
    }
    void escaped(const Vec3f& from, const WalkEdge& edge, int depth) override {
        ended = true;
        escapeFrom = from;
        escapeDirection = edge.ray.direction;
        escapeThroughput = edge.throughput;
        escapeMis = edge.mis;
        escapeDepth = depth;
    }
};

Vertex withoutHistory(Vertex v) {
    v.mis = {};
    return v;
}

double ratio(const Rgb& a, const Rgb& b) {
    return luminance(b) > 0 ? double(luminance(a)) / luminance(b) : -1;
}

/// Lighting, whether there is merging, Strategies::connect.
class MisOracle : public ::testing::TestWithParam<std::tuple<Lighting, bool, double>> {};

TEST_P(MisOracle, RecursiveWeightsEqualBruteForceAndSumToOne) {
    const auto [lighting, merging, connect] = GetParam();
    const std::shared_ptr<Scene> scenePtr = makeScene(lighting);
    const Scene& scene = *scenePtr;
    const PathLimits limits = scene.parts().limits;
    const double radius = 0.05, pixels = 32 * 24;
    // A density of photons that makes the shares of merging differ from vertex to vertex.
    PhotonDensity photons(0.5);
    constexpr int kPhotonSubpaths = 2000;
    for (uint64_t i = 0; i < kPhotonSubpaths; ++i) {
        IndependentStream stream(hashKey(i, 4));
        Collector subpath;
        traceLightSubpath(scene, stream, limits, Strategies::path(), subpath);
        for (const Vertex& v : subpath.vertices) photons.count(v.si.p);
    }
    photons.endIteration(0.01 * kPhotonSubpaths);  // as if a hundred times as dense
    Strategies n = Strategies::bidirectional(3.7, merging ? pixels * std::numbers::pi * radius * radius : 0,
                                             &photons, 0.3);
    n.connect = connect;
    int reduced = 0;  // vertices whose share is less than one
    // With this every other technique vanishes from the weight: the contribution itself.
    const Strategies alone{1e30, 1, 0, nullptr};
    const Strategies aloneMerge{1e30, 1, 1e30, nullptr};
    const BruteForce oracle(scene, n);
    const Light* light = scene.lights()[0].get();

    std::map<std::string, int> checked;
    std::map<std::string, std::vector<double>> deviations;
    double worstSum = 0;
    const auto check = [&](const std::string& name, int s, const FullPath& path, double weight) {
        if (!path.found || !oracle.wellConditioned(path)) return;
        const auto weights = oracle.weights(path);
        double sum = 0;
        for (const auto& [key, w] : weights) sum += w;
        worstSum = std::max(worstSum, std::abs(sum - 1));
        const auto it = weights.find({name, s});
        ASSERT_NE(it, weights.end()) << name << " " << s << " is not a technique of this path";
        ++checked[name];
        deviations[name].push_back(std::abs(weight - it->second) / std::max(it->second, 1e-3));
    };

    constexpr int kWanted = 10000;
    for (uint64_t i = 0; i < 1000000; ++i) {
        IndependentStream eyeStream(hashKey(i, 1)), lightStream(hashKey(i, 2));
        CounterRng rng(hashKey(i, 3));
        Collector eye, fromLight;
        traceEyeSubpath(scene, eyeStream, limits, n, Vec2f(rng.next1D() * 32, rng.next1D() * 24), 1, 0, eye);
        traceLightSubpath(scene, lightStream, limits, n, fromLight);
        const std::vector<Vertex>&e = eye.vertices, &l = fromLight.vertices;
        for (const Vertex& v : e) reduced += v.mergeShare < 0.9f;

        const auto lightEnd = [&](FullPath& path, const Vertex& first) {
            path.light = light;
            path.infinite = light->isInfinite();
            path.toLight = first.toPrevious;
            path.lightPosition = first.si.p + first.toPrevious * first.distanceToPrevious;
            if (!path.infinite && !light->isDelta()) {
                SurfaceInteraction si;
                // A point on a sphere's silhouette may be missed by the rounded ray: such a path is left out.
                path.found = scene.intersect({offsetRayOrigin(first.si.p, first.si.ng, first.toPrevious),
                                              first.toPrevious, kInfinity},
                                             si) &&
                             si.shape->emitter.get() == light;
                path.lightPoint = si;
                path.lightPosition = si.p;
            }
        };
        const auto appendLight = [&](FullPath& path, size_t count) {
            lightEnd(path, l[0]);
            for (size_t j = 0; j < count; ++j) path.inner.push_back(l[j].si);
        };
        const auto appendEye = [&](FullPath& path, size_t count) {
            for (size_t j = count; j-- > 0;) path.inner.push_back(e[j].si);
        };

        // hit
        if (checked["hit"] < kWanted && !light->isDelta()) {
            if (light->isEnvironment() && eye.ended && e.size() >= 1) {
                FullPath path;
                path.light = light;
                path.infinite = true;
                path.toLight = eye.escapeDirection;
                appendEye(path, e.size());
                const double w =
                    ratio(hitEnvironment(scene, n, eye.escapeFrom, eye.escapeDirection, eye.escapeThroughput,
                                         eye.escapeMis, eye.escapeDepth),
                          light->environmentRadiance(eye.escapeDirection) * eye.escapeThroughput);
                check("hit", 0, path, w);
            }
            for (size_t j = 1; j < e.size(); ++j) {
                if (e[j].si.shape->emitter.get() != light) continue;
                const Rgb all = light->radiance(e[j].si, e[j].toPrevious) * e[j].throughput;
                if (isBlack(all)) continue;
                FullPath path;
                path.light = light;
                path.lightPoint = e[j].si;
                path.lightPosition = e[j].si.p;
                appendEye(path, j);
                check("hit", 0, path, ratio(hitLight(scene, n, e[j]), all));
            }
        }
        // nee: the light-side term of the weight remains when the history is taken away, so that it is put
        // back by hand.
        for (size_t j = 0; j < e.size() && j < 3 && checked["nee"] < kWanted; ++j) {
            if (!e[j].bsdf().hasSmoothLobe()) continue;
            const Vec2f u = rng.next2D();
            const Rgb weighted = connectToLight(scene, n, e[j], 0.5f, u);
            const auto c = light->connect(e[j].si.p, u);
            if (isBlack(weighted) || !c) continue;
            const Rgb all = e[j].throughput * scatterEye(e[j], c->wi).value * c->value *
                            (1.0f / scene.connectionProbability(e[j].si.p, light));
            FullPath path;
            Vertex first = e[j];
            first.toPrevious = c->wi;
            first.distanceToPrevious = c->distance;
            lightEnd(path, first);
            appendEye(path, j + 1);
            check("nee", 1, path, ratio(weighted, all));
        }
        // splat
        for (size_t j = 0; j < l.size() && j < 3 && checked["splat"] < kWanted; ++j) {
            if (!l[j].bsdf().hasSmoothLobe()) continue;
            Vec2f raster;
            const Rgb weighted = connectToCamera(scene, n, l[j], Vec2f(0.5f), true, raster);
            if (isBlack(weighted)) continue;
            FullPath path;
            appendLight(path, j + 1);
            check("splat", static_cast<int>(j) + 2, path,
                  ratio(weighted, connectToCamera(scene, n, l[j], Vec2f(0.5f), false, raster)));
        }
        // connect and merge; the two vertices of a merge are moved onto each other, so that the path is one
        // path
        for (size_t a = 0; a < l.size() && a < 3; ++a)
            for (size_t b = 0; b < e.size() && b < 3; ++b) {
                if (!l[a].bsdf().hasSmoothLobe() || !e[b].bsdf().hasSmoothLobe()) continue;
                if (checked["connect"] < kWanted) {
                    const Rgb weighted = connectVertices(scene, n, l[a], e[b]);
                    const double d2 = lengthSquared(l[a].si.p - e[b].si.p);
                    if (!isBlack(weighted) && d2 > 1e-4) {
                        FullPath path;
                        appendLight(path, a + 1);
                        appendEye(path, b + 1);
                        check("connect", static_cast<int>(a) + 2, path,
                              ratio(weighted, connectVertices(scene, alone, withoutHistory(l[a]),
                                                              withoutHistory(e[b]))));
                    }
                }
            }
        // merge: the eye subpath is led to a light vertex by retracing its last edge toward it
        for (size_t a = 0; a < l.size() && a < 3 && merging && checked["merge"] < kWanted; ++a) {
            if (!l[a].bsdf().hasSmoothLobe()) continue;
            const size_t b = static_cast<size_t>(rng.next1D() * 2.999f);
            if (b > e.size() || (b > 0 && !e[b - 1].bsdf().hasSmoothLobe())) continue;
            const Vec3f from = b == 0 ? scene.camera().position() : e[b - 1].si.p;
            const Vec3f ngFrom = b == 0 ? Vec3f(0.0f) : e[b - 1].si.ng;
            if (!scene.visible(l[a].si.p, l[a].si.ng, from, ngFrom)) continue;
            Vertex joined = l[a];
            joined.toPrevious = directionBetween(l[a].si.p, from);
            joined.distanceToPrevious = (from - l[a].si.p).length();
            joined.throughput = Rgb(1.0f);
            const double cosine = absDot(joined.toPrevious, joined.si.ng);
            const double d2 = sqr(double(joined.distanceToPrevious));
            if (!(cosine > 1e-4) || !(d2 > 1e-4)) continue;
            if (b == 0) {
                const auto c = scene.camera().connect(l[a].si.p, Vec2f(0.5f));
                if (!c) continue;
                joined.mis = MisState::startEye(n, c->pdfDirection);
            } else {
                const VertexScattering s = scatterEye(e[b - 1], -joined.toPrevious);
                if (!(s.pdfForward > 0)) continue;
                joined.mis = e[b - 1].mis;
                joined.mis.scatter(n, absDot(joined.toPrevious, e[b - 1].si.ng), s.pdfForward, s.pdfReverse,
                                   e[b - 1].mergeShare);
            }
            joined.mergeShare = b == 0 ? 1.0f : static_cast<float>(n.mergeShare(joined.si.p));
            joined.mis.arrive(d2, cosine);
            const Rgb weighted = mergeVertices(n, l[a], joined, 1);
            if (isBlack(weighted)) continue;
            FullPath path;
            appendLight(path, a + 1);
            appendEye(path, b);
            check(
                "merge", static_cast<int>(a) + 1, path,
                ratio(weighted, mergeVertices(aloneMerge, withoutHistory(l[a]), withoutHistory(joined), 1)));
        }
        bool enough =
            checked["nee"] >= kWanted && checked["splat"] >= kWanted && checked["connect"] >= kWanted;
        enough = enough && (light->isDelta() || checked["hit"] >= kWanted) &&
                 (!merging || checked["merge"] >= kWanted);
        if (enough) break;
    }
    for (const auto& [name, count] : checked) {
        if (name == "hit" && light->isDelta()) continue;
        if (name == "merge" && !merging) continue;
        EXPECT_GE(count, kWanted) << name;
        std::vector<double>& d = deviations[name];
        std::sort(d.begin(), d.end());
        EXPECT_LT(d[d.size() * 999 / 1000], 1e-4) << name << " over " << count << " paths";
        // Rounding changes the sum of the others; how much of that a weight feels grows as it is made
        // smaller.
        EXPECT_LT(d.back(), 2e-3 / connect) << name << " over " << count << " paths";
    }
    EXPECT_LT(worstSum, 1e-9);
    if (merging) {
        EXPECT_GT(reduced, 1000) << "the photons' density made no difference";
    }
}

INSTANTIATE_TEST_SUITE_P(AllLights, MisOracle,
                         ::testing::Combine(::testing::Values(Lighting::Area, Lighting::SphereArea,
                                                              Lighting::Point, Lighting::Directional,
                                                              Lighting::Constant),
                                            ::testing::Bool(), ::testing::Values(1.0, 0.25)));

}  // namespace
}  // namespace metrolux::core
