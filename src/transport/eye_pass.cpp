#include "transport/eye_pass.h"

#include "base/parallel.h"
#include "sampling/streams.h"
#include "transport/connect.h"
#include "transport/subpath.h"

namespace metrolux {

namespace {

/// Adds up hit and nee of one eye subpath and keeps its vertices.
class EyeVisitor final : public SubpathVisitor {
  public:
    EyeVisitor(const EyePass& pass, SampleStream& nee, Film& film, std::vector<Vertex>& kept)
        : pass_(pass), nee_(nee), film_(film), kept_(kept) {}

    const Rgb& sum() const { return sum_; }

    bool surface(const Vertex& v) override {
        const PathLimits& limits = pass_.limits;
        if (v.si.shape->emitter && countsHit(v.depth)) add(hitLight(pass_.scene, pass_.strategies, v));
        if (pass_.deepest >= 0 && v.depth >= pass_.deepest) return false;
        gathers_ = v.bsdf().hasSmoothLobe() && !(pass_.photonMapping && v.bsdf().isNarrow(v.si));
        if (gathers_) {
            const bool extensible = limits.maxDepth < 0 || v.depth < limits.maxDepth;
            if (pass_.nextEvent && extensible) sum_ += pass_.estimateDirect(v, nee_, film_);
            if (pass_.keepVertices && extensible) kept_.push_back(v);
        }
        return true;
    }

    bool scattered(bool delta) override { return delta || !pass_.photonMapping || !gathers_; }

    void escaped(const Vec3f& from, const Vec3f& direction, const Rgb& throughput, const MisState& mis,
                 int depth) override {
        if (countsHit(depth))
            add(hitEnvironment(pass_.scene, pass_.strategies, from, direction, throughput, mis, depth));
    }

  private:
    bool countsHit(int depth) const {
        if (depth == 1) return pass_.direct && !pass_.limits.hideEmitters;
        return pass_.hit;
    }
    void add(const Rgb& value) {
        if (!film_.rejectNonFinite(value, Technique::Hit)) sum_ += value;
    }

    const EyePass& pass_;
    SampleStream& nee_;
    Film& film_;
    std::vector<Vertex>& kept_;
    Rgb sum_{0.0f};
    bool gathers_ = false;  ///< at the last vertex
};

}  // namespace

Rgb EyePass::estimateDirect(const Vertex& v, SampleStream& nee, Film& film) const {
    nee.seek(v.depth);
    const float uLight = nee.next1D();
    nee.skip(1);  // keeps the pair that follows aligned
    const Rgb value = connectToLight(scene, strategies, v, uLight, nee.next2D());
    return film.rejectNonFinite(value, Technique::Nee) ? Rgb(0.0f) : value;
}

Rgb EyePass::trace(SampleStream& stream, SampleStream& nee, const Vec2f& raster, float weight, uint32_t pixel,
                   Film& film, std::vector<Vertex>& kept) const {
    EyeVisitor visitor(*this, nee, film, kept);
    traceEyeSubpath(scene, stream, limits, strategies, raster, weight, pixel, visitor);
    return visitor.sum();
}

void EyePass::run(std::span<const uint32_t> pixels, Film& film, EyeVertices& result) const {
    constexpr size_t kChunk = 256;
    const size_t chunks = (pixels.size() + kChunk - 1) / kChunk;
    std::vector<std::vector<Vertex>> kept(chunks);
    result.starts_.assign(keepVertices ? pixels.size() + 1 : 0, 0);

    parallelFor(chunks, [&](size_t chunk) {
        for (size_t i = chunk * kChunk; i < std::min(pixels.size(), (chunk + 1) * kChunk); ++i) {
            const uint32_t pixel = pixels[i];
            // Keyed by the position in the full image, so that a crop repeats the samples of the whole.
            const FilmWindow& w = film.window();
            const uint64_t x = w.x + pixel % w.width, y = w.y + pixel / w.width;
            const uint64_t key = hashKey(seed, StreamPurpose::EyeSubpath, x, y);
            SobolStream stream(key, pass), nee(hashKey(key, 0x6e6565), pass);
            stream.seek(0);
            float weight = 1;
            const Vec2f raster = film.samplePosition(pixel, stream.next2D(), weight);
            const size_t before = kept[chunk].size();
            film.addEye(pixel, trace(stream, nee, raster, weight, pixel, film, kept[chunk]));
            if (keepVertices) result.starts_[i + 1] = kept[chunk].size() - before;
        }
    });

    result.vertices_.clear();
    if (!keepVertices) return;
    for (size_t i = 0; i < pixels.size(); ++i) result.starts_[i + 1] += result.starts_[i];
    result.vertices_.resize(result.starts_.back());
    parallelFor(chunks, [&](size_t chunk) {
        std::uninitialized_copy(kept[chunk].begin(), kept[chunk].end(),
                                result.vertices_.begin() + result.starts_[chunk * kChunk]);
        std::vector<Vertex>().swap(kept[chunk]);
    });
}

}  // namespace metrolux
