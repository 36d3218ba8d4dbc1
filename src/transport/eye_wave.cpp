#include "transport/eye_wave.h"

#include "sampling/sample_stream.h"
#include "sampling/sobol.h"

namespace metrolux::core {

void EyeWave::run(std::span<const uint32_t> pixels, Kept& kept) {
    start(pixels);
    constexpr size_t kUsual = 4;  // vertices of a subpath
    if (pass_.keepVertices) {
        kept.vertices.reserve(kUsual * pixels.size());
        kept.places.reserve(kUsual * pixels.size());
    }
    for (int depth = 1; !active_.empty(); ++depth) {
        pass_.scene.intersector().intersect(rays_, depth == 1 ? Coherence::High : Coherence::None);
        arrive(pixels, depth);
        makeNumbers(depth);
        // One loop for each thing to do: its code stays in the cache, and the processor overlaps lanes.
        gather(kept);
        estimateDirect();
        scatter(depth);
    }
    for (size_t i = 0; i < pixels.size(); ++i) film_.addEye(pixels[i], lanes_[i].sum);
}

void EyeWave::start(std::span<const uint32_t> pixels) {
    const size_t n = pixels.size();
    lanes_.assign(n, {});
    eyeKeys_.resize(n);
    neeKeys_.resize(n);
    for (size_t i = 0; i < n; ++i) {
        const uint64_t key = pass_.key(film_.window(), pixels[i]);
        eyeKeys_[i] = hashKey(key);
        neeKeys_[i] = hashKey(EyePass::neeKey(key));
    }
    const uint32_t index = sobol::reverseBits(pass_.pass);
    std::vector<float> rasterX(n), rasterY(n), lensX(n), lensY(n);
    sobol::points2D(eyeKeys_, index, 0, rasterX.data(), rasterY.data());
    sobol::points2D(eyeKeys_, index, 2, lensX.data(), lensY.data());

    const WalkRules walk = pass_.rules();
    active_.clear();
    rays_.clear();
    for (size_t i = 0; i < n; ++i) {
        float weight = 1;
        const Vec2f raster = film_.samplePosition(pixels[i], {rasterX[i], rasterY[i]}, weight);
        if (!startEye(walk, {lensX[i], lensY[i]}, raster, weight, lanes_[i].edge)) continue;
        active_.push_back(static_cast<uint32_t>(i));
        rays_.rays.push_back(lanes_[i].edge.ray);
    }
}

void EyeWave::arrive(std::span<const uint32_t> pixels, int depth) {
    const WalkRules walk = pass_.rules();
    const Intersector& intersector = pass_.scene.intersector();
    size_t arrived = 0;
    for (size_t k = 0; k < active_.size(); ++k) {
        intersector.prefetchAfter(rays_, k);
        Lane& lane = lanes_[active_[k]];
        Vertex& v = lane.v;
        const Vec3f from = depth == 1 ? lane.edge.ray.origin : v.si.p;
        if (!rays_.hits[k].found()) {
            gathering_.escaped(from, lane.edge, depth, lane.sum);
            continue;
        }
        intersector.interaction(rays_, k, v.si);
        if (!(depth == 1 ? arriveFromCamera(walk, lane.edge, pixels[active_[k]], v)
                         : metrolux::core::arrive(lane.edge, from, lane.certain, v)))
            continue;
        // Read when all lanes have arrived.
        v.bsdf().prefetch(v.si);
        if (!lane.certain) pass_.strategies.prefetchMergeShare(v.si.p);
        active_[arrived++] = active_[k];
    }
    active_.resize(arrived);
    if (depth > 1)
        for (const uint32_t i : active_) weighMerging(walk, lanes_[i].certain, lanes_[i].v);
}

void EyeWave::makeNumbers(int depth) {
    const size_t n = active_.size();
    const auto pick = [&](const std::vector<uint64_t>& all, std::vector<uint64_t>& keys) {
        keys.resize(n);
        for (size_t k = 0; k < n; ++k) keys[k] = all[active_[k]];
    };
    const uint32_t index = sobol::reverseBits(pass_.pass);
    const auto first = static_cast<uint64_t>(SampleStream::blockOffset(depth));
    Numbers& u = numbers_;
    const auto points1D = [&](const std::vector<uint64_t>& keys, uint64_t offset, std::vector<float>& x) {
        x.resize(n);
        sobol::points1D(keys, index, first + offset, x.data());
    };
    const auto points2D = [&](const std::vector<uint64_t>& keys, uint64_t offset, std::vector<float>& x,
                              std::vector<float>& y) {
        x.resize(n);
        y.resize(n);
        sobol::points2D(keys, index, first + offset, x.data(), y.data());
    };
    pick(eyeKeys_, u.eyeKeys);
    points1D(u.eyeKeys, 0, u.lobe);
    points2D(u.eyeKeys, 1, u.scatterX, u.scatterY);
    if (pass_.rules().plays(depth)) points1D(u.eyeKeys, 3, u.roulette);
    if (!pass_.nextEvent) return;
    pick(neeKeys_, u.neeKeys);
    points1D(u.neeKeys, EyePass::kLightCoordinate, u.light);
    points2D(u.neeKeys, EyePass::kLightPointCoordinate, u.lightX, u.lightY);
}

void EyeWave::gather(Kept& kept) {
    for (const uint32_t i : active_) {
        Lane& lane = lanes_[i];
        gathering_.hit(lane.v, lane.sum);
        lane.gathers = !gathering_.ends(lane.v) && gathering_.gathers(lane.v);
        if (!pass_.keepVertices || !lane.gathers || !gathering_.extensible(lane.v)) continue;
        kept.vertices.resize(kept.vertices.size() + 1);
        copyVertex(lane.v, &kept.vertices.back());
        kept.places.push_back(i);
    }
}

void EyeWave::estimateDirect() {
    if (!pass_.nextEvent) return;
    const Numbers& u = numbers_;
    PendingConnection pending;
    for (size_t k = 0; k < active_.size(); ++k) {
        const Lane& lane = lanes_[active_[k]];
        if (!lane.gathers || !gathering_.extensible(lane.v) ||
            !prepareLight(pass_.scene, pass_.strategies, lane.v, u.light[k], {u.lightX[k], u.lightY[k]},
                          pending))
            continue;
        waiting_.push_back({active_[k], pending.value});
        shadows_.rays.push_back(pending.shadow);
    }
    pass_.scene.intersector().occluded(shadows_);
    for (size_t i = 0; i < waiting_.size(); ++i)
        if (!shadows_.blocked[i] && !film_.rejectNonFinite(waiting_[i].value, Technique::Nee))
            lanes_[waiting_[i].lane].sum += waiting_[i].value;
    waiting_.clear();
    shadows_.clear();
}

void EyeWave::scatter(int depth) {
    const WalkRules walk = pass_.rules();
    const Numbers& u = numbers_;
    size_t left = 0;
    rays_.clear();
    if (depth < walk.depthLimit())
        for (size_t k = 0; k < active_.size(); ++k) {
            const uint32_t i = active_[k];
            Lane& lane = lanes_[i];
            if (gathering_.ends(lane.v) ||
                !metrolux::core::scatter(
                    walk, lane.v, u.lobe[k], {u.scatterX[k], u.scatterY[k]}, [&] { return u.roulette[k]; },
                    lane.edge) ||
                !gathering_.follows(lane.gathers, lane.edge.delta))
                continue;
            active_[left++] = i;
            rays_.rays.push_back(lane.edge.ray);
        }
    active_.resize(left);
}

}  // namespace metrolux::core
