#include "wavefront/eye_wavefront.h"

#include "base/parallel.h"
#include "base/prefetch.h"
#include "sampling/sobol.h"
#include "sampling/streams.h"
#include "transport/connect.h"
#include "wavefront/prefetching.h"

#include <tbb/task_arena.h>

#include <array>

namespace metrolux::core {

void EyeWavefront::run(std::span<const uint32_t> pixels, Kept& kept) {
    start(pixels);
    constexpr size_t kUsual = 4;  // vertices of a subpath
    if (pass_.strategies.joinsSubpaths()) {
        kept.vertices.reserve(kUsual * pixels.size());
        kept.places.reserve(kUsual * pixels.size());
    }
    for (int depth = 1; !active_.empty(); ++depth) {
        pass_.scene.intersector().intersect(rays_, depth == 1 ? Coherence::High : Coherence::None);
        arrive(pixels, depth);
        makeNumbers(depth);
        // One loop for each thing to do: its code stays in the cache, and the processor overlaps subpaths.
        gather(kept);
        estimateDirect();
        scatter(depth);
    }
    for (size_t i = 0; i < pixels.size(); ++i) pass_.add(pixels[i], subpaths_[i].sum, film_);
}

void EyeWavefront::start(std::span<const uint32_t> pixels) {
    const size_t n = pixels.size();
    subpaths_.assign(n, {});
    eyeKeys_.resize(n);
    neeKeys_.resize(n);
    for (size_t i = 0; i < n; ++i) {
        const uint64_t key = pass_.key(film_.window(), pixels[i]);
        eyeKeys_[i] = hashKey(key);
        neeKeys_[i] = hashKey(EyePass::neeKey(key));
    }
    const uint32_t index = sobol::reverseBits(pass_.pass);
    std::vector<float> rasterX(n), rasterY(n), lensX(n), lensY(n);
    sobol::points2D(eyeKeys_, index, layout::kRaster.place, rasterX.data(), rasterY.data());
    sobol::points2D(eyeKeys_, index, layout::kLens.place, lensX.data(), lensY.data());

    const WalkRules walk = pass_.rules();
    active_.clear();
    rays_.clear();
    for (size_t i = 0; i < n; ++i) {
        float weight = 1;
        const Vec2f raster = film_.samplePosition(pixels[i], {rasterX[i], rasterY[i]}, weight);
        if (!startEye(walk, {lensX[i], lensY[i]}, raster, weight, subpaths_[i].edge)) continue;
        active_.push_back(static_cast<uint32_t>(i));
        rays_.rays.push_back(subpaths_[i].edge.ray);
    }
}

void EyeWavefront::arrive(std::span<const uint32_t> pixels, int depth) {
    const WalkRules walk = pass_.rules();
    const Intersector& intersector = pass_.scene.intersector();
    size_t arrived = 0;
    for (size_t k = 0; k < active_.size(); ++k) {
        intersector.prefetchAfter(rays_, k);
        Subpath& subpath = subpaths_[active_[k]];
        Vertex& v = subpath.v;
        const Vec3f from = depth == 1 ? subpath.edge.ray.origin : v.si.p;
        bool found = rays_.hits[k].found();
        if (found) intersector.interaction(rays_, k, v.si);
        if (walk.scene.hasMedia()) {
            SobolStream stream(pass_.key(film_.window(), pixels[active_[k]]), pass_.pass);
            found = passMedia(walk, stream, depth, found, subpath.edge, v);
        }
        if (!found) {
            subpath.sum.add(pass_.escaped(from, subpath.edge, depth));
            continue;
        }
        if (!(depth == 1 ? arriveFromCamera(walk, subpath.edge, pixels[active_[k]], v)
                         : metrolux::core::arrive(subpath.edge, from, subpath.certain, v)))
            continue;
        // Read when all subpaths have arrived.
        if (!subpath.certain) prefetchMergeShare(pass_.strategies, v.si.p);
        active_[arrived++] = active_[k];
    }
    active_.resize(arrived);
    if (depth > 1 || walk.scene.hasMedia())  // on surfaces the first vertex has what it began with
        for (const uint32_t i : active_) weighMerging(walk, subpaths_[i].certain, subpaths_[i].v);
}

void EyeWavefront::makeNumbers(int depth) {
    const size_t n = active_.size();
    const auto pick = [&](const std::vector<uint64_t>& all, std::vector<uint64_t>& keys) {
        keys.resize(n);
        for (size_t k = 0; k < n; ++k) keys[k] = all[active_[k]];
    };
    const uint32_t index = sobol::reverseBits(pass_.pass);
    Numbers& u = numbers_;
    const auto makeOne = [&](const std::vector<uint64_t>& keys, layout::One coordinate, int block,
                             std::vector<float>& x) {
        x.resize(n);
        sobol::points1D(keys, index, static_cast<uint64_t>(indexOf(coordinate, block)), x.data());
    };
    const auto makeTwo = [&](const std::vector<uint64_t>& keys, layout::Two coordinates, int block,
                             std::vector<float>& x, std::vector<float>& y) {
        x.resize(n);
        y.resize(n);
        sobol::points2D(keys, index, static_cast<uint64_t>(indexOf(coordinates, block)), x.data(), y.data());
    };
    const int block = pass_.rules().block(depth);
    pick(eyeKeys_, u.eyeKeys);
    makeOne(u.eyeKeys, layout::kLobe, block, u.lobe);
    makeTwo(u.eyeKeys, layout::kDirection, block, u.scatterX, u.scatterY);
    if (pass_.rules().plays(depth)) makeOne(u.eyeKeys, layout::kRoulette, block, u.roulette);
    if (!(pass_.strategies.nee > 0)) return;
    pick(neeKeys_, u.neeKeys);
    makeOne(u.neeKeys, layout::kNeeLight, depth, u.light);
    makeTwo(u.neeKeys, layout::kNeePoint, depth, u.lightX, u.lightY);
}

void EyeWavefront::gather(Kept& kept) {
    const bool keeps = pass_.strategies.joinsSubpaths();
    for (const uint32_t i : active_) {
        Subpath& subpath = subpaths_[i];
        subpath.sum.add(pass_.hit(subpath.v));
        subpath.joins = pass_.joins(subpath.v);
        if (!keeps || !subpath.joins || !pass_.extensible(subpath.v)) continue;
        kept.vertices.resize(kept.vertices.size() + 1);
        copyVertex(subpath.v, &kept.vertices.back());
        kept.places.push_back(i);
    }
}

void EyeWavefront::estimateDirect() {
    if (!(pass_.strategies.nee > 0)) return;
    const Numbers& u = numbers_;
    PendingConnection pending;
    for (size_t k = 0; k < active_.size(); ++k) {
        const Subpath& subpath = subpaths_[active_[k]];
        if (!subpath.joins || !pass_.extensible(subpath.v) ||
            !prepareLight(pass_.scene, pass_.strategies, subpath.v, u.light[k], {u.lightX[k], u.lightY[k]},
                          pending))
            continue;
        waiting_.push_back({active_[k], pending});
        shadows_.rays.push_back(pending.shadow);
    }
    pass_.scene.intersector().occluded(shadows_);
    for (size_t i = 0; i < waiting_.size(); ++i) {
        Subpath& subpath = subpaths_[waiting_[i].subpath];
        subpath.sum.add(pass_.finite(
            findLight(subpath.v, waiting_[i].connection, visibility(shadows_.blocked[i])), Technique::Nee));
    }
    waiting_.clear();
    shadows_.clear();
}

void EyeWavefront::scatter(int depth) {
    const WalkRules walk = pass_.rules();
    const Numbers& u = numbers_;
    size_t left = 0;
    rays_.clear();
    if (depth < walk.depthLimit())
        for (size_t k = 0; k < active_.size(); ++k) {
            const uint32_t i = active_[k];
            Subpath& subpath = subpaths_[i];
            if (!metrolux::core::scatter(
                    walk, subpath.v, u.lobe[k], {u.scatterX[k], u.scatterY[k]}, [&] { return u.roulette[k]; },
                    subpath.edge) ||
                !pass_.follows(subpath.joins, subpath.edge.delta))
                continue;
            active_[left++] = i;
            rays_.rays.push_back(subpath.edge.ray);
        }
    active_.resize(left);
}

void EyeWavefronts::run(const EyePass& pass, std::span<const uint32_t> pixels, Film& film,
                        EyeVertices& result) {
    const size_t tasks = (pixels.size() + kTask - 1) / kTask;
    // Vertices are gathered and put in order group by group, so that they are twice in memory for a group
    // only.
    const size_t group =
        std::max(kGroup / kTask, 8 * static_cast<size_t>(tbb::this_task_arena::max_concurrency()));
    const bool keeps = pass.strategies.joinsSubpaths();
    result.vertices.clear();
    result.starts.assign(keeps ? pixels.size() + 1 : 1, 0);
    if (kept_.size() < std::min(group, tasks)) kept_.resize(std::min(group, tasks));
    for (size_t first = 0; first < tasks; first += group) {
        const size_t count = std::min(group, tasks - first);
        parallelFor(count, [&](size_t i) {
            const size_t pixel = (first + i) * kTask;
            EyeWavefront(pass, film)
                .run(pixels.subspan(pixel, std::min(kTask, pixels.size() - pixel)), kept_[i]);
        });
        if (keeps) takeKept(first * kTask, count, result);
    }
}

void EyeWavefronts::takeKept(size_t first, size_t tasks, EyeVertices& result) {
    auto& [vertices, starts] = result;
    const size_t subpaths = result.subpathCount(), last = std::min(first + tasks * kTask, subpaths);
    for (size_t task = 0; task < tasks; ++task)
        for (const uint32_t place : kept_[task].places) ++starts[first + task * kTask + place + 1];
    for (size_t i = first; i < last; ++i) starts[i + 1] += starts[i];
    if (starts[last] > vertices.capacity())  // of all subpaths, if the others are like these
        vertices.reserve(starts[last] * (subpaths + subpaths / 8) / last + kTask);
    vertices.resize(starts[last]);
    parallelFor(tasks, [&](size_t task) {
        const size_t begin = first + task * kTask;
        std::array<size_t, kTask> next;  // of each subpath
        std::copy_n(result.starts.begin() + static_cast<ptrdiff_t>(begin), std::min(kTask, last - begin),
                    next.begin());
        EyeWavefront::Kept& from = kept_[task];
        for (size_t i = 0; i < from.vertices.size(); ++i)
            copyVertex(from.vertices[i], &result.vertices[next[from.places[i]]++]);
        from.vertices.clear();
        from.places.clear();
    });
}

size_t EyeWavefronts::memoryBytes() const {
    size_t sum = 0;
    for (const EyeWavefront::Kept& k : kept_)
        sum += k.vertices.capacity() * sizeof(Vertex) + k.places.capacity() * sizeof(uint32_t);
    return sum;
}

}  // namespace metrolux::core
