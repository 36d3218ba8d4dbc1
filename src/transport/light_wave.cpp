#include "transport/light_wave.h"

#include "base/prefetch.h"

#include <limits>

namespace metrolux::core {

namespace {
/// How many steps of a loop ahead memory is asked for.
constexpr size_t kAhead = 8;
/// Vertices of an eye subpath that are asked for when it has been chosen.
constexpr size_t kPrefetched = 4;
}  // namespace

void LightWave::run(const LightPass& pass, std::span<const LightJob> jobs, Coherence coherence) {
    begin(pass, jobs, coherence);
    for (Lane& lane : lanes_) choosePartner(lane);
    trace();
}

void LightWave::run(const LightPass& pass, const LightJob& job, std::span<const Vertex> partner,
                    float connectionScale) {
    begin(pass, {&job, 1}, Coherence::Alone);
    lanes_[0].partner = partner;
    lanes_[0].connectionScale = connectionScale;
    trace();
}

void LightWave::begin(const LightPass& pass, std::span<const LightJob> jobs, Coherence coherence) {
    pass_ = &pass;
    coherence_ = coherence;
    limit_ = pass.limits.maxDepth < 0 ? std::numeric_limits<int>::max() / 2 : pass.limits.maxDepth;
    lanes_.assign(jobs.size(), {});
    for (size_t i = 0; i < jobs.size(); ++i) {
        lanes_[i].job = jobs[i];
        jobs[i].splats->clear();
        if (jobs[i].trail) jobs[i].trail->clear();
    }
}

/// One eye subpath of N is picked, by a share of the light subpaths: its pixel's share stands for all.
void LightWave::choosePartner(Lane& lane) const {
    const EyeVertices& eyes = pass_->eyes;
    SampleStream& stream = *lane.job.stream;
    stream.seek(0);
    stream.skip(LightPass::kEyeSubpathCoordinate);
    const float u = stream.next1D();
    const double share = pass_->strategies.connect;
    if (!pass_->connect || eyes.subpathCount() == 0 || !(double(u) < share)) return;
    const size_t n = eyes.subpathCount();
    lane.partner = eyes.subpath(std::min(static_cast<size_t>(double(u) / share * double(n)), n - 1));
    lane.connectionScale = static_cast<float>(double(n) / share);
    prefetch(lane.partner.data(), std::min(lane.partner.size(), kPrefetched) * sizeof(Vertex));
}

void LightWave::trace() {
    start();
    for (int depth = 1; !active_.empty(); ++depth) {
        pass_->scene.intersector().intersect(rays_, coherence_);
        arrive(depth);
        // One loop for each thing to do: its code stays in the cache, and the processor overlaps lanes.
        prepare();
        merge(depth);
        splat(depth);
        connect(depth);
        scatter(depth);
    }
}

void LightWave::start() {
    const WalkRules walk = pass_->rules();
    starts_.resize(lanes_.size());
    active_.clear();
    rays_.clear();
    for (size_t i = 0; i < lanes_.size(); ++i) {
        Lane& lane = lanes_[i];
        SampleStream& stream = *lane.job.stream;
        lane.uLens = LightPass::lensCoordinates(stream);
        if (!startLight(walk, stream, starts_[i])) continue;
        active_.push_back(static_cast<uint32_t>(i));
        rays_.rays.push_back(starts_[i].ray);
    }
}

void LightWave::arrive(int depth) {
    const WalkRules walk = pass_->rules();
    const Intersector& intersector = pass_->scene.intersector();
    const bool merging = pass_->merge && !pass_->grid.empty();
    size_t arrived = 0;
    for (size_t k = 0; k < active_.size(); ++k) {
        intersector.prefetchAfter(rays_, k);
        const uint32_t i = active_[k];
        Lane& lane = lanes_[i];
        Vertex& v = lane.v;
        if (!rays_.hits[k].found()) continue;
        const Vec3f from = v.si.p;
        intersector.interaction(rays_, k, v.si);
        bool certain = false;
        if (!(depth == 1 ? arriveFromLight(walk, starts_[i], v)
                         : metrolux::core::arrive(lane.edge, from, certain, v)))
            continue;
        // What the next steps read, when all lanes have arrived.
        v.bsdf().prefetch(v.si);
        walk.strategies.prefetchMergeShare(v.si.p);
        lane.smooth = v.bsdf().hasSmoothLobe();
        lane.merges = lane.smooth && merging;
        if (lane.merges) lane.cells = pass_->grid.locate(v.si.p);
        if (lane.smooth && lane.job.counted) lane.counted = lane.job.counted->locate(v.si.p);
        active_[arrived++] = i;
    }
    active_.resize(arrived);
}

void LightWave::prepare() {
    const WalkRules walk = pass_->rules();
    for (const uint32_t i : active_) {
        Lane& lane = lanes_[i];
        weighMerging(walk, false, lane.v);
        if (lane.merges) pass_->grid.prefetchEntries(lane.cells);
        if (!lane.smooth) continue;
        if (lane.job.counted) lane.job.counted->count(lane.counted);
        if (lane.job.trail) lane.job.trail->push_back(lane.v.si.p);
    }
}

void LightWave::splat(int depth) {
    if (!pass_->splat || !(depth < limit_)) return;
    uint64_t tried = 0;
    PendingConnection pending;
    Vec2f raster;
    for (const uint32_t i : active_) {
        const Lane& lane = lanes_[i];
        if (!lane.smooth) continue;
        ++tried;
        if (!prepareCamera(pass_->scene, pass_->strategies, lane.v, lane.uLens, pass_->weighted, raster,
                           pending))
            continue;
        waiting_.push_back({i, 0, raster, pending.value});
        shadows_.rays.push_back(pending.shadow);
    }
    if (pass_->work) pass_->work->splats += tried;
    traceShadows();
    for (const Waiting& w : waiting_)
        if (!pass_->film.rejectNonFinite(w.value, Technique::Splat))
            lanes_[w.lane].job.splats->film.push_back({w.raster, w.value});
    waiting_.clear();
}

void LightWave::connect(int depth) {
    uint64_t tried = 0;
    PendingConnection pending;
    for (const uint32_t i : active_) {
        const Lane& lane = lanes_[i];
        if (!lane.smooth) continue;
        for (const Vertex& eye : lane.partner) {
            if (depth + eye.depth + 1 > limit_) break;
            ++tried;
            if (!prepareVertices(pass_->scene, pass_->strategies, lane.v, eye, pending)) continue;
            waiting_.push_back({i, eye.pixel, Vec2f(0.0f), pending.value * lane.connectionScale});
            shadows_.rays.push_back(pending.shadow);
        }
    }
    if (pass_->work) pass_->work->connections += tried;
    traceShadows();
    for (const Waiting& w : waiting_) addPixel(lanes_[w.lane], w.pixel, w.value, Technique::Connect);
    waiting_.clear();
}

/// Leaves in waiting_ what nothing blocks.
void LightWave::traceShadows() {
    if (waiting_.empty()) return;
    pass_->scene.intersector().occluded(shadows_, coherence_);
    size_t free = 0;
    for (size_t k = 0; k < waiting_.size(); ++k)
        if (!shadows_.blocked[k]) waiting_[free++] = waiting_[k];
    waiting_.resize(free);
    shadows_.clear();
}

void LightWave::merge(int depth) {
    const std::span<const Vertex> eyes = pass_->eyes.all();
    const VertexGrid& grid = pass_->grid;
    near_.clear();
    for (const uint32_t i : active_) {
        Lane& lane = lanes_[i];
        if (lane.merges) grid.addWithin(lane.v.si.p, lane.cells, near_);
        lane.nearEnd = near_.size();
    }
    const double r = grid.radius(), inverseDiskArea = 1.0 / (double(kPi) * r * r);
    const auto ahead = [&](size_t k) {
        if (k < near_.size()) prefetch(&eyes[near_[k]], sizeof(Vertex));
    };
    for (size_t k = 0; k < kAhead; ++k) ahead(k);
    uint64_t merged = 0;
    size_t k = 0;
    for (const uint32_t i : active_)
        for (const Lane& lane = lanes_[i]; k < lane.nearEnd; ++k) {
            ahead(k + kAhead);
            const Vertex& eye = eyes[near_[k]];
            if (depth + eye.depth > limit_) continue;
            ++merged;
            addPixel(lane, eye.pixel,
                     mergeVertices(pass_->strategies, lane.v, eye, inverseDiskArea, pass_->weighted),
                     Technique::Merge);
        }
    if (pass_->work) pass_->work->merges += merged;
}

void LightWave::scatter(int depth) {
    const WalkRules walk = pass_->rules();
    size_t left = 0;
    rays_.clear();
    if (depth + 1 < limit_ && depth < walk.depthLimit())
        for (const uint32_t i : active_) {
            Lane& lane = lanes_[i];
            if (!metrolux::core::scatter(walk, *lane.job.stream, lane.v, lane.edge)) continue;
            active_[left++] = i;
            rays_.rays.push_back(lane.edge.ray);
        }
    active_.resize(left);
}

void LightWave::addPixel(const Lane& lane, uint32_t pixel, const Rgb& value, Technique technique) const {
    if (!pass_->film.rejectNonFinite(value, technique) && !isBlack(value))
        lane.job.splats->pixels.push_back({pixel, value});
}

}  // namespace metrolux::core
