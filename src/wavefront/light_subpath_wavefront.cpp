#include "wavefront/light_subpath_wavefront.h"

#include "transport/connect.h"
#include "wavefront/prefetching.h"

namespace metrolux::core {

namespace {

/// How many steps of a loop ahead memory is prefetched.
constexpr size_t kAhead = 8;
/// Vertices of an eye subpath that are prefetched when it has been chosen.
constexpr size_t kPrefetched = 4;

class LightSubpathWavefront {
  public:
    void run(const LightSubpathPass& pass, std::span<const LightSubpathJob> jobs, Coherence coherence);

  private:
    struct Subpath {
        LightSubpathJob job;
        LightSubpathPass::Partner partner;
        Vec2f uLens;
        Vertex v;
        WalkEdge edge;
        VertexGrid::Cells cells;
        PhotonDensity::Bucket counted = 0;
        // At the last vertex:
        bool smooth = false, isCounted = false;
        const VertexGrid* grid = nullptr;  ///< LightSubpathPass::gridFor()
        size_t nearEnd = 0;                ///< where its own end in near_
    };
    /// A connection of a subpath that waits for its shadow ray.
    struct Waiting {
        uint32_t subpath;
        uint32_t pixel;
        Vec2f raster;
        LightFinding found;
    };

    void start();
    void arrive(int depth);
    void prepare();
    void merge(int depth);
    void splat(int depth);
    void connect(int depth);
    void traceShadows();
    void scatter(int depth);

    const LightSubpathPass* pass_ = nullptr;  ///< during run()
    Coherence coherence_ = Coherence::None;
    std::vector<Subpath> subpaths_;
    std::vector<LightStart> starts_;  ///< of each subpath
    std::vector<uint32_t> active_;    ///< subpaths on their way
    RayBatch rays_;                   ///< of active_
    OcclusionBatch shadows_;
    std::vector<Waiting> waiting_;  ///< of shadows_
    /// Eye vertices within the radius of the subpaths' vertices, subpath after subpath.
    UninitializedVector<uint32_t> near_;
};

void LightSubpathWavefront::run(const LightSubpathPass& pass, std::span<const LightSubpathJob> jobs,
                                Coherence coherence) {
    pass_ = &pass;
    coherence_ = coherence;
    subpaths_.assign(jobs.size(), {});
    for (size_t i = 0; i < jobs.size(); ++i) {
        Subpath& subpath = subpaths_[i];
        subpath.job = jobs[i];
        jobs[i].splats->clear();
        if (jobs[i].trail) jobs[i].trail->clear();
        subpath.partner = pass.choosePartner(*jobs[i].stream);
        const std::span<const Vertex> vertices = subpath.partner.vertices;
        prefetch(vertices.data(), std::min(vertices.size(), kPrefetched) * sizeof(Vertex));
    }
    start();
    for (int depth = 1; !active_.empty(); ++depth) {
        pass_->scene.intersector().intersect(rays_, coherence_);
        arrive(depth);
        // One loop for each thing to do: its code stays in the cache, and the processor overlaps subpaths.
        prepare();
        merge(depth);
        splat(depth);
        connect(depth);
        scatter(depth);
    }
}

void LightSubpathWavefront::start() {
    const WalkRules walk = pass_->rules();
    starts_.resize(subpaths_.size());
    active_.clear();
    rays_.clear();
    for (size_t i = 0; i < subpaths_.size(); ++i) {
        Subpath& subpath = subpaths_[i];
        SampleStream& stream = *subpath.job.stream;
        subpath.uLens = read(stream, layout::kSplatLens);
        if (!startLight(walk, stream, starts_[i])) continue;
        active_.push_back(static_cast<uint32_t>(i));
        rays_.rays.push_back(starts_[i].ray);
    }
}

void LightSubpathWavefront::arrive(int depth) {
    const WalkRules walk = pass_->rules();
    const Intersector& intersector = pass_->scene.intersector();
    size_t arrived = 0;
    for (size_t k = 0; k < active_.size(); ++k) {
        intersector.prefetchAfter(rays_, k);
        const uint32_t i = active_[k];
        Subpath& subpath = subpaths_[i];
        Vertex& v = subpath.v;
        const Vec3f from = v.si.p;
        const bool found = rays_.hits[k].found();
        if (found) intersector.interaction(rays_, k, v.si);
        SampleStream& stream = *subpath.job.stream;
        if (!(depth == 1 ? passMedia(walk, stream, found, starts_[i], v)
                         : passMedia(walk, stream, depth, found, subpath.edge, v)))
            continue;
        bool certain = false;
        if (!(depth == 1 ? arriveFromLight(walk, starts_[i], v)
                         : metrolux::core::arrive(subpath.edge, from, certain, v)))
            continue;
        // What the next steps read, when all subpaths have arrived.
        prefetchMergeShare(walk.strategies, v.si.p);
        subpath.smooth = v.hasSmoothLobe();
        subpath.grid = subpath.smooth ? pass_->gridFor(v) : nullptr;
        if (subpath.grid) {
            subpath.cells = subpath.grid->cellsOf(v.si.p);
            prefetchBuckets(*subpath.grid, subpath.cells);
        }
        subpath.isCounted = subpath.smooth && !v.inMedium;
        if (subpath.isCounted && subpath.job.counted) {
            subpath.counted = subpath.job.counted->bucketOf(v.si.p);
            prefetchCounter(*subpath.job.counted, subpath.counted);
        }
        active_[arrived++] = i;
    }
    active_.resize(arrived);
}

void LightSubpathWavefront::prepare() {
    const WalkRules walk = pass_->rules();
    for (const uint32_t i : active_) {
        Subpath& subpath = subpaths_[i];
        weighMerging(walk, false, subpath.v);
        if (subpath.grid) prefetchEntries(*subpath.grid, subpath.cells);
        if (!subpath.isCounted) continue;
        if (subpath.job.counted) subpath.job.counted->count(subpath.counted);
        if (subpath.job.trail) subpath.job.trail->push_back(subpath.v.si.p);
    }
}

void LightSubpathWavefront::splat(int depth) {
    if (!(pass_->strategies.splat > 0) || !pass_->limits.admits(depth + 1)) return;
    uint64_t tried = 0;
    PendingConnection pending;
    Vec2f raster;
    for (const uint32_t i : active_) {
        const Subpath& subpath = subpaths_[i];
        if (!subpath.smooth) continue;
        ++tried;
        if (!prepareCamera(pass_->scene, pass_->strategies, subpath.v, subpath.uLens, raster, pending))
            continue;
        waiting_.push_back({i, 0, raster, {pending.value, pending.eye}});
        shadows_.rays.push_back(pending.shadow);
    }
    if (pass_->work) pass_->work->splats += tried;
    traceShadows();
    for (const Waiting& w : waiting_) pass_->addToFilm(w.raster, w.found, *subpaths_[w.subpath].job.splats);
    waiting_.clear();
}

void LightSubpathWavefront::connect(int depth) {
    uint64_t tried = 0;
    PendingConnection pending;
    for (const uint32_t i : active_) {
        const Subpath& subpath = subpaths_[i];
        if (!subpath.smooth) continue;
        for (const Vertex& eye : subpath.partner.vertices) {
            if (!pass_->limits.admits(depth + eye.depth + 1)) continue;
            ++tried;
            if (!prepareVertices(pass_->scene, pass_->strategies, subpath.v, eye, pending)) continue;
            waiting_.push_back(
                {i, eye.pixel, Vec2f(0.0f), {pending.value * subpath.partner.scale, pending.eye}});
            shadows_.rays.push_back(pending.shadow);
        }
    }
    if (pass_->work) pass_->work->connections += tried;
    traceShadows();
    for (const Waiting& w : waiting_)
        pass_->addPixel(w.pixel, w.found, Technique::Connect, *subpaths_[w.subpath].job.splats);
    waiting_.clear();
}

/// Leaves in waiting_ what gets through.
void LightSubpathWavefront::traceShadows() {
    if (waiting_.empty()) return;
    pass_->scene.intersector().occluded(shadows_, coherence_);
    size_t left = 0;
    for (size_t k = 0; k < waiting_.size(); ++k) {
        const Rgb value = throughEdge(waiting_[k].found.value, visibility(shadows_.blocked[k]));
        if (isBlack(value)) continue;
        waiting_[left] = waiting_[k];
        waiting_[left++].found.value = value;
    }
    waiting_.resize(left);
    shadows_.clear();
}

void LightSubpathWavefront::merge(int depth) {
    const std::span<const Vertex> eyes = pass_->eyes.all();
    near_.clear();
    for (const uint32_t i : active_) {
        Subpath& subpath = subpaths_[i];
        if (subpath.grid) appendWithin(*subpath.grid, subpath.v.si.p, subpath.cells, near_);
        subpath.nearEnd = near_.size();
    }
    const auto ahead = [&](size_t k) {
        if (k < near_.size()) prefetch(&eyes[near_[k]], sizeof(Vertex));
    };
    for (size_t k = 0; k < kAhead; ++k) ahead(k);
    uint64_t merged = 0;
    size_t k = 0;
    for (const uint32_t i : active_) {
        const Subpath& subpath = subpaths_[i];
        if (k == subpath.nearEnd) continue;
        const double kernel = LightSubpathPass::kernelOf(*subpath.grid, subpath.v.inMedium);
        for (; k < subpath.nearEnd; ++k) {
            ahead(k + kAhead);
            const Vertex& eye = eyes[near_[k]];
            if (!pass_->limits.admits(depth + eye.depth)) continue;
            ++merged;
            pass_->merge(subpath.v, near_[k], kernel, *subpath.job.splats);
        }
    }
    if (pass_->work) pass_->work->merges += merged;
}

void LightSubpathWavefront::scatter(int depth) {
    const WalkRules walk = pass_->rules();
    size_t left = 0;
    rays_.clear();
    if ((pass_->limits.maxDepth < 0 || depth + 2 <= pass_->limits.maxDepth) && depth < walk.depthLimit())
        for (const uint32_t i : active_) {
            Subpath& subpath = subpaths_[i];
            if (!metrolux::core::scatter(walk, *subpath.job.stream, subpath.v, subpath.edge)) continue;
            active_[left++] = i;
            rays_.rays.push_back(subpath.edge.ray);
        }
    active_.resize(left);
}

}  // namespace

void evaluateTogether(const LightSubpathPass& pass, std::span<const LightSubpathJob> jobs,
                      Coherence coherence) {
    static thread_local LightSubpathWavefront wavefront;  // keeps its memory from call to call
    wavefront.run(pass, jobs, coherence);
}

}  // namespace metrolux::core
