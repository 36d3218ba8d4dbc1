#include "transport/eye_pass.h"

#include "base/parallel.h"
#include "sampling/streams.h"
#include "transport/connect.h"
#include "transport/eye_wave.h"
#include "transport/subpath.h"

#include <tbb/task_arena.h>

#include <array>

namespace metrolux::core {

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
    constexpr size_t kTask = EyeVertices::kTask;
    const size_t tasks = (pixels.size() + kTask - 1) / kTask;
    // Vertices are gathered and put in order group by group, so that they are twice in memory for a group
    // only.
    const size_t group = std::max(EyeVertices::kGroup / kTask,
                                  8 * static_cast<size_t>(tbb::this_task_arena::max_concurrency()));
    result.begin(keepVertices ? pixels.size() : 0, std::min(group, tasks));
    for (size_t first = 0; first < tasks; first += group) {
        const size_t count = std::min(group, tasks - first);
        parallelFor(count, [&](size_t i) {
            const size_t pixel = (first + i) * kTask;
            EyeWave(*this, film)
                .run(pixels.subspan(pixel, std::min(kTask, pixels.size() - pixel)), result.kept_[i]);
        });
        if (keepVertices) result.takeKept(first * kTask, count);
    }
}

void EyeVertices::begin(size_t subpaths, size_t tasks) {
    vertices_.clear();
    starts_.assign(subpaths > 0 ? subpaths + 1 : 0, 0);
    if (kept_.size() < tasks) kept_.resize(tasks);
}

void EyeVertices::takeKept(size_t first, size_t tasks) {
    const size_t last = std::min(first + tasks * kTask, subpathCount());
    for (size_t task = 0; task < tasks; ++task)
        for (const uint32_t place : kept_[task].places) ++starts_[first + task * kTask + place + 1];
    for (size_t i = first; i < last; ++i) starts_[i + 1] += starts_[i];
    if (starts_[last] > vertices_.capacity())  // of all subpaths, if the others are like these
        vertices_.reserve(starts_[last] * (subpathCount() + subpathCount() / 8) / last + kTask);
    vertices_.resize(starts_[last]);
    parallelFor(tasks, [&](size_t task) {
        const size_t begin = first + task * kTask;
        std::array<size_t, kTask> next;  // of each subpath
        std::copy_n(starts_.begin() + static_cast<ptrdiff_t>(begin), std::min(kTask, last - begin),
                    next.begin());
        Kept& from = kept_[task];
        for (size_t i = 0; i < from.vertices.size(); ++i)
            copyVertex(from.vertices[i], &vertices_[next[from.places[i]]++]);
        from.vertices.clear();
        from.places.clear();
    });
}

}  // namespace metrolux::core
