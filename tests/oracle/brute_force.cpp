#include "oracle/brute_force.h"

#include "scattering/fresnel.h"

namespace metrolux::core::test {

namespace {

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

/// Probability with which sample() follows the delta lobe from `known` to `wanted`: the measure of the
/// numbers uLobe that pick it, whatever densities it reports. The lobe must be wider than a cell of the
/// search.
double lobeProbability(const SurfaceInteraction& si, const Vec3f& known, const Vec3f& wanted,
                       TransportMode mode) {
    constexpr int kCells = 48, kHalvings = 22;
    constexpr float kSameDirection = 1 - 1e-4f;
    const auto picks = [&](double uLobe) {
        const auto s = si.shape->bsdf->sample(si, known, mode, static_cast<float>(uLobe), Vec2f(0.5f));
        return s && s->delta && dot(normalize(s->direction), wanted) > kSameDirection;
    };
    double measure = 0;
    bool before = picks(0);
    for (int i = 1; i <= kCells; ++i) {
        double low = double(i - 1) / kCells,
               high = i < kCells ? double(i) / kCells : double(kOneMinusEpsilon);
        const bool after = picks(high);
        if (before && after) measure += high - low;
        if (before != after) {
            const double begin = low, end = high;
            for (int k = 0; k < kHalvings; ++k) {
                const double middle = 0.5 * (low + high);
                (picks(middle) == before ? low : high) = middle;
            }
            measure += before ? low - begin : end - low;
        }
        before = after;
    }
    return measure;
}

}  // namespace

/// Directions and squared lengths of a path's edges.
struct BruteForce::Geometry {
    Geometry(const OracleScene& oracle, const FullPath& fullPath)
        : path(fullPath),
          m(static_cast<int>(path.inner.size())),
          eye(oracle.lens.point(path.uLens)),
          infiniteEye(oracle.lens.kind == Lens::Orthographic),
          axis(oracle.lens.axis),
          lens(oracle.lens),
          media(oracle.media) {}

    const FullPath& path;
    int m;  ///< inner vertices; the camera is x_{m+1}
    Vec3f eye;
    bool infiniteEye;
    Vec3f axis;
    const OracleLens& lens;
    const OracleMedia& media;

    /// Probability that a walk along the edge from x_i to x_{i+1} gets through, of the whole path: for i = 0
    /// from the light, for i = m from where rays of the camera begin.
    Rgb survival(int i) const {
        const float far = 100;
        if (i == 0)
            return media.survival(infiniteLight() ? x(1).p + path.toLight * far : path.lightPosition, x(1).p);
        if (i < m) return media.survival(x(i).p, x(i + 1).p);
        const Vec3f w = towardEye(m);
        const float along = -dot(w, axis);
        const float length = infiniteEye ? dot(x(m).p - lens.origin, axis) : (eye - x(m).p).length();
        return media.survival(x(m).p, x(m).p + w * (length - static_cast<float>(lens.near) / along));
    }
    /// Factor of the density of x_i from its being the end of a walk through an edge.
    double arrival(int i, const Rgb& survived) const {
        if (!inMedium(i)) {
            const bool veil = x(i).shape->bsdf->hasNullLobe();
            return double(average(survived)) * (veil && media.present ? stopAtVeil() : 1.0);
        }
        return double(average(survived * media.extinction(x(i).p)));
    }
    /// The probability not to pass it.
    double stopAtVeil() const { return double(OracleMedia::kVeilOpacity); }

    const SurfaceInteraction& x(int i) const { return path.inner[i - 1].si; }
    bool infiniteLight() const { return path.light->isInfinite(); }
    Vec3f towardLight(int i) const {
        if (i > 1) return directionBetween(x(i).p, x(i - 1).p);
        return infiniteLight() ? path.toLight : directionBetween(x(1).p, path.lightPosition);
    }
    Vec3f towardEye(int i) const {
        if (i < m) return directionBetween(x(i).p, x(i + 1).p);
        return infiniteEye ? -axis : directionBetween(x(m).p, eye);
    }
    /// Factor of a direction in the density of x_i: none in a medium.
    double cosine(int i, const Vec3f& w) const { return inMedium(i) ? 1.0 : double(absDot(w, x(i).ng)); }
    bool inMedium(int i) const { return x(i).ng == Vec3f(0.0f); }
    double cosineAtLight() const {
        return infiniteLight() || path.light->isDelta() ? 1.0 : absDot(towardLight(1), path.lightPoint.ng);
    }
    /// Of the first edge: 1 at infinite lights.
    double firstLengthSquared() const {
        return infiniteLight() ? 1.0 : lengthSquared(x(1).p - path.lightPosition);
    }
};

std::map<TechniqueKey, double> BruteForce::weights(const FullPath& path) const {
    const Geometry g(oracle_, path);
    const int m = g.m;
    const auto joins = [&](int i) { return g.x(i).shape->bsdf->hasSmoothLobe() && !path.inner[i - 1].delta; };

    // Densities per area of x_i: forward[i] from the light side, backward[i] from the camera side.
    std::vector<double> forward(m + 1), backward(m + 1);
    const EndpointDensities d = densities(path, g);
    const double d2 = g.firstLengthSquared();
    const double emission = scene_.emissionProbability(path.light);
    forward[0] = (g.infiniteLight() ? d.pdfDirection : d.pdfPosition) * emission;
    forward[1] = (g.infiniteLight() ? d.pdfPosition : d.pdfDirection / d2) * g.cosine(1, g.towardLight(1)) *
                 g.arrival(1, g.survival(0));
    double nee0 = scene_.connectionProbability(g.x(1).p, path.light);
    if (!path.light->isDelta()) nee0 *= d.connect * (g.infiniteLight() ? 1.0 : g.cosineAtLight() / d2);

    for (int i = 1; i < m; ++i)
        forward[i + 1] = scatterDensity(path.inner[i - 1], g.towardLight(i), g.towardEye(i), true) *
                         g.cosine(i + 1, g.towardEye(i)) * g.arrival(i + 1, g.survival(i)) /
                         lengthSquared(g.x(i + 1).p - g.x(i).p);
    for (int i = m; i >= 1; --i) {
        const double pdf = scatterDensity(path.inner[i - 1], g.towardLight(i), g.towardEye(i), false);
        if (i > 1)
            backward[i - 1] = pdf * g.cosine(i - 1, g.towardLight(i)) * g.arrival(i - 1, g.survival(i - 1)) /
                              lengthSquared(g.x(i - 1).p - g.x(i).p);
        else
            backward[0] =
                (g.infiniteLight() ? pdf : pdf * g.cosineAtLight() / d2) * double(average(g.survival(0)));
    }
    const double cosine = g.cosine(m, g.towardEye(m)) * g.arrival(m, g.survival(m));
    backward[m] = g.infiniteEye
                      ? oracle_.lens.pdfPosition() * cosine
                      : oracle_.lens.pdfDirection(-g.towardEye(m)) * cosine / lengthSquared(g.x(m).p - g.eye);

    const auto product = [&](int s) {  // P_s over x_0 ... x_m
        double value = 1;
        for (int i = 0; i < s; ++i) value *= forward[i];
        for (int i = s; i <= m; ++i) value *= backward[i];
        return value;
    };
    std::map<TechniqueKey, double> density;
    const auto smooth =
        std::count_if(path.inner.begin(), path.inner.end(), [](const InnerVertex& v) { return !v.delta; });
    const double factor = n_.eyeFactor({n_.regionOf(path.raster), static_cast<int>(smooth)});
    if (!path.light->isDelta()) density[{"hit", 0}] = factor * n_.hit * product(0);
    if (joins(1) && path.light->isConnectable())
        density[{"nee", 1}] = factor * n_.nee * nee0 * product(0) / backward[0];
    for (int s = 2; s <= m; ++s)
        if (joins(s - 1) && joins(s)) density[{"connect", s}] = n_.connect * product(s);
    if (joins(m)) density[{"splat", m + 1}] = n_.splat * product(m + 1);
    if (n_.merge > 0) {
        bool certain = true;  // only delta scattering between x_s and the camera
        for (int s = m; s >= 1; --s) {
            if (!joins(s)) continue;
            const double share = g.inMedium(s) ? n_.mergeInMedia : certain ? 1.0 : n_.mergeShare(g.x(s).p);
            density[{"merge", s}] = n_.merge * product(s) * forward[s] * share;
            certain = false;
        }
    }
    double sum = 0;
    for (const auto& [key, value] : density) sum += value;
    for (auto& [key, value] : density) value /= sum;
    return density;
}

bool BruteForce::wellConditioned(const FullPath& path) const {
    const Geometry g(oracle_, path);
    const auto grazing = [&](int i, const Vec3f& w) {
        if (g.inMedium(i)) return false;
        const InnerVertex& v = path.inner[i - 1];
        const float least = v.si.shape->bsdf->hasSmoothLobe() && !v.delta ? 0.2f : 0.4f;
        return absDot(w, v.si.ng) < least || absDot(w, v.si.ns) < least;
    };
    constexpr float kShortest = 0.3f;
    constexpr float kFar = 100;
    for (int i = 1; i <= g.m; ++i)
        if (oracle_.media.isGrazing(g.x(i).p, i < g.m ? g.x(i + 1).p : g.x(i).p + g.towardEye(i)))
            return false;
    if (oracle_.media.isGrazing(g.x(1).p, g.x(1).p + g.towardLight(1) * kFar)) return false;
    for (int i = 1; i <= g.m; ++i)
        if (grazing(i, g.towardLight(i)) || grazing(i, g.towardEye(i))) return false;
    for (int i = 1; i < g.m; ++i)
        if ((g.x(i).p - g.x(i + 1).p).length() < kShortest) return false;
    if (!g.infiniteEye && (g.x(g.m).p - g.eye).length() < kShortest) return false;
    if (g.infiniteLight()) return true;
    // A vertex in a medium lies on the ray, which starts off the lamp, and not quite in its direction from
    // there.
    const double leastCosine = oracle_.media.present ? 0.4 : 0.2;
    return g.firstLengthSquared() >= sqr(kShortest) && g.cosineAtLight() >= leastCosine;
}

EndpointDensities BruteForce::densities(const FullPath& path, const Geometry& g) const {
    const Vec3f x1 = g.x(1).p;
    if (!path.light->isDelta())
        return path.light->isInfinite() ? path.light->environmentDensities(x1, path.toLight)
                                        : path.light->densities(x1, path.lightPoint);
    EndpointDensities d;
    d.pdfPosition = d.pdfDirection = 1;
    if (!path.light->isConnectable()) return d;  // a beam: delta in position and direction
    const auto c = path.light->connect(x1, Vec2f(0.5f));
    d.pdfPosition = c->pdfPosition;
    d.pdfDirection = c->pdfDirection;
    return d;
}

double BruteForce::scatterDensity(const InnerVertex& v, const Vec3f& wLight, const Vec3f& wEye,
                                  bool forward) const {
    const SurfaceInteraction& si = v.si;
    const Bsdf& bsdf = *si.shape->bsdf;
    if (bsdf.hasSmoothLobe() && !v.delta) {
        const BsdfEvaluation e = bsdf.evaluate(si, si.toLocal(wEye), si.toLocal(wLight));
        return forward ? e.pdfEye : e.pdfLight;
    }
    const double cl = dot(wLight, si.ns), ce = dot(wEye, si.ns);
    double probability = 0;
    if (bsdf.hasSmoothLobe()) {
        const Vec3f light = si.toLocal(wLight), eye = si.toLocal(wEye);
        probability = forward ? lobeProbability(si, light, eye, TransportMode::Importance)
                              : lobeProbability(si, eye, light, TransportMode::Radiance);
    } else {
        const double reflectance = fresnelDielectric(static_cast<float>(forward ? cl : ce), kGlassEta);
        probability = cl * ce > 0 ? reflectance : 1 - reflectance;
    }
    if (forward || cl * ce > 0 || &bsdf == oracle_.veil.get()) return probability;
    return probability * refractionJacobian(wLight, si.ns, cl > 0 ? 1 / kGlassEta : kGlassEta);
}

}  // namespace metrolux::core::test
