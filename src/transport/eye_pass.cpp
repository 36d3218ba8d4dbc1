#include "transport/eye_pass.h"

#include "sampling/streams.h"
#include "transport/connect.h"
#include "transport/subpath.h"

namespace metrolux::core {

namespace {

/// Adds up hit and nee of one eye subpath and keeps its vertices.
class EyeVisitor final : public SubpathVisitor {
  public:
    EyeVisitor(const EyePass& pass, SampleStream* nee, std::vector<Vertex>& kept)
        : pass_(pass), nee_(nee), kept_(kept) {}

    const EyeSum& sum() const { return sum_; }

    bool surface(const Vertex& v) override {
        sum_.add(pass_.hit(v));
        joins_ = pass_.joins(v);
        if (joins_ && pass_.extensible(v)) {
            if (nee_ && pass_.strategies.nee > 0) sum_.add(pass_.estimateDirect(v, *nee_));
            if (pass_.strategies.joinsSubpaths()) kept_.push_back(v);
        }
        return true;
    }

    bool scattered(bool delta) override { return pass_.follows(joins_, delta); }

    void escaped(const Vec3f& from, const WalkEdge& edge, int depth) override {
        sum_.add(pass_.escaped(from, edge, depth));
    }

  private:
    const EyePass& pass_;
    SampleStream* nee_;
    std::vector<Vertex>& kept_;
    EyeSum sum_;
    bool joins_ = false;  ///< at the last vertex
};

}  // namespace

void EyePass::run(std::span<const uint32_t> pixels, Film& film, EyeVertices& result) const {
    result.clear();
    std::vector<Vertex> kept;
    for (const uint32_t pixel : pixels) {
        const uint64_t subpath = key(film.window(), pixel);
        SobolStream stream(subpath, pass), nee(neeKey(subpath), pass);
        float weight = 1;
        const Vec2f raster = film.samplePosition(pixel, read(stream, layout::kRaster), weight);
        kept.clear();
        add(pixel, trace(stream, &nee, raster, weight, pixel, kept), film);
        result.append(kept);
    }
}

void EyePass::add(uint32_t pixel, const EyeSum& sum, Film& film) const {
    film.addEye(pixel, sum.value);
    if (factors) factors->set(pixel, sum.alone);
}

EyeSum EyePass::trace(SampleStream& stream, SampleStream* nee, const Vec2f& raster, float weight,
                      uint32_t pixel, std::vector<Vertex>& kept) const {
    EyeVisitor visitor(*this, nee, kept);
    traceEyeSubpath(scene, stream, limits, strategies, raster, weight, pixel, visitor);
    return visitor.sum();
}

uint64_t EyePass::key(const FilmWindow& w, uint32_t pixel) const {
    // Keyed by the position in the full image, so that a crop repeats the samples of the whole.
    const uint64_t x = w.x + pixel % w.width, y = w.y + pixel / w.width;
    return hashKey(seed, StreamPurpose::EyeSubpath, x, y);
}

EyeFinding EyePass::hit(const Vertex& v) const {
    if (!v.emitter() || !countsHit(v.depth)) return {};
    return finite(hitLight(scene, strategies, v), Technique::Hit);
}

EyeFinding EyePass::escaped(const Vec3f& from, const WalkEdge& edge, int depth) const {
    if (!countsHit(depth)) return {};
    return finite(hitEnvironment(scene, strategies, from, edge, depth), Technique::Hit);
}

EyeFinding EyePass::estimateDirect(const Vertex& v, SampleStream& nee) const {
    const float uLight = read(nee, layout::kNeeLight, v.depth);
    const Vec2f uPoint = read(nee, layout::kNeePoint, v.depth);
    return finite(connectToLight(scene, strategies, v, uLight, uPoint), Technique::Nee);
}

}  // namespace metrolux::core
