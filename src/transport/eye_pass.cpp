#include "transport/eye_pass.h"

#include "base/parallel.h"
#include "sampling/streams.h"
#include "transport/connect.h"
#include "transport/eye_wave.h"
#include "transport/subpath.h"

#include <array>
#include <memory>

namespace metrolux {

namespace {

/// Adds up hit and nee of one eye subpath and keeps its vertices.
class EyeVisitor final : public SubpathVisitor {
  public:
    EyeVisitor(const EyePass& pass, SampleStream& nee, Film& film, std::vector<Vertex>& kept)
        : pass_(pass), gathering_(pass, film), nee_(nee), film_(film), kept_(kept) {}

    const Rgb& sum() const { return sum_; }

    bool surface(const Vertex& v) override {
        gathering_.hit(v, sum_);
        if (gathering_.ends(v)) return false;
        gathers_ = gathering_.gathers(v);
        if (gathers_ && gathering_.extensible(v)) {
            if (pass_.nextEvent) sum_ += pass_.estimateDirect(v, nee_, film_);
            if (pass_.keepVertices) kept_.push_back(v);
        }
        return true;
    }

    bool scattered(bool delta) override { return gathering_.follows(gathers_, delta); }

    void escaped(const Vec3f& from, const WalkEdge& edge, int depth) override {
        gathering_.escaped(from, edge, depth, sum_);
    }

  private:
    const EyePass& pass_;
    EyeGathering gathering_;
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
    nee.skip(kLightPointCoordinate - kLightCoordinate - 1);
    const Rgb value = connectToLight(scene, strategies, v, uLight, nee.next2D());
    return film.rejectNonFinite(value, Technique::Nee) ? Rgb(0.0f) : value;
}

Rgb EyePass::trace(SampleStream& stream, SampleStream& nee, const Vec2f& raster, float weight, uint32_t pixel,
                   Film& film, std::vector<Vertex>& kept) const {
    EyeVisitor visitor(*this, nee, film, kept);
    traceEyeSubpath(scene, stream, limits, strategies, raster, weight, pixel, visitor);
    return visitor.sum();
}

uint64_t EyePass::key(const FilmWindow& w, uint32_t pixel) const {
    // Keyed by the position in the full image, so that a crop repeats the samples of the whole.
    const uint64_t x = w.x + pixel % w.width, y = w.y + pixel / w.width;
    return hashKey(seed, StreamPurpose::EyeSubpath, x, y);
}

void EyePass::run(std::span<const uint32_t> pixels, Film& film, EyeVertices& result) const {
    constexpr size_t kChunk = 512;
    const size_t chunks = (pixels.size() + kChunk - 1) / kChunk;
    std::vector<EyeWave::Kept> kept(chunks);

    parallelFor(chunks, [&](size_t chunk) {
        const size_t first = chunk * kChunk;
        EyeWave(*this, film).run(pixels.subspan(first, std::min(kChunk, pixels.size() - first)), kept[chunk]);
    });

    result.vertices_.clear();
    result.starts_.assign(keepVertices ? pixels.size() + 1 : 0, 0);
    if (!keepVertices) return;
    for (size_t chunk = 0; chunk < chunks; ++chunk)
        for (const uint32_t place : kept[chunk].places) ++result.starts_[chunk * kChunk + place + 1];
    for (size_t i = 0; i < pixels.size(); ++i) result.starts_[i + 1] += result.starts_[i];
    result.vertices_.resize(result.starts_.back());
    parallelFor(chunks, [&](size_t chunk) {
        const size_t first = chunk * kChunk;
        std::array<size_t, kChunk> next;  // of each subpath
        std::copy_n(result.starts_.begin() + static_cast<ptrdiff_t>(first),
                    std::min(kChunk, pixels.size() - first), next.begin());
        EyeWave::Kept& from = kept[chunk];
        for (size_t i = 0; i < from.vertices.size(); ++i)
            copyVertex(from.vertices[i], &result.vertices_[next[from.places[i]]++]);
        from = {};
    });
}

}  // namespace metrolux
