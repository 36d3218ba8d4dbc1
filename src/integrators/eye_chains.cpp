#include "integrators/eye_chains.h"

#include <numeric>

namespace metrolux::core {

namespace {

uint32_t pixelAt(const FilmWindow& w, const Vec2f& u) {
    const int x = std::min(static_cast<int>(u.x * static_cast<float>(w.width)), w.width - 1);
    const int y = std::min(static_cast<int>(u.y * static_cast<float>(w.height)), w.height - 1);
    return static_cast<uint32_t>(y) * w.width + x;
}

/// The numbers below `count` in random order.
std::vector<uint32_t> shuffled(size_t count, uint64_t key) {
    std::vector<uint32_t> result(count);
    std::iota(result.begin(), result.end(), 0u);
    CounterRng rng(key);
    for (size_t i = count; i > 1; --i) {
        const auto j = static_cast<size_t>(rng.nextDouble() * double(i));
        std::swap(result[i - 1], result[std::min(j, i - 1)]);
    }
    return result;
}

}  // namespace

/// An eye pass as the model of ReplicaLanes.
struct EyeChains::Model {
    const EyePass& pass;
    const VertexGrid& lightVertices;
    Film& film;
    std::span<const uint32_t> order;
    double count;                      ///< samples that the iteration stands for
    std::span<const uint32_t> strata;  ///< of the curve, one for each uniform sample
    uint64_t neeKey;
    std::vector<Weighted>& weighted;

    /// Uniform samples are spread evenly over the image, in random order: a visible one becomes the state of
    /// the lane's chain, which keeps its distribution if the samples of a lane do not depend on each other.
    /// (A sequence in which a lane wandered along the curve left its chains waiting where visible parts end:
    /// cbox, 6 % too bright there with Kelemen's kernel.)
    void startUniform(PrimarySample& u, CounterRng& rng, size_t lane, size_t step) const {
        const uint32_t stratum = strata[step * weighted.size() + lane];
        const double along = (stratum + rng.nextDouble()) / double(strata.size()) * double(order.size());
        const uint32_t pixel = order[std::min(static_cast<size_t>(along), order.size() - 1)];
        const FilmWindow& w = film.window();
        const uint32_t column = pixel % w.width, row = pixel / w.width;
        const double x = (column + rng.nextDouble()) / w.width;
        const double y = (row + rng.nextDouble()) / w.height;
        u.push_back(std::min(static_cast<float>(x), kOneMinusEpsilon));
        u.push_back(std::min(static_cast<float>(y), kOneMinusEpsilon));
    }

    using Evaluations = std::span<const Evaluation<EyeSubpath>>;
    void evaluateUniform(Evaluations evaluations) const { evaluate(evaluations); }
    void evaluate(Evaluations evaluations) const {
        for (const auto& [stream, value] : evaluations) evaluate(*stream, *value);
    }
    void evaluate(SampleStream& u, EyeSubpath& e) const {
        e.pixel = pixelAt(film.window(), read(u, layout::kRaster));
        float weight = 1;
        const Vec2f raster = film.samplePosition(e.pixel, read(u, layout::kFilter), weight);
        e.vertices.clear();
        // Next-event estimation waits until the subpath has a weight.
        e.hit = pass.trace(u, nullptr, raster, weight, e.pixel, e.vertices).value;
        e.size = std::any_of(e.vertices.begin(), e.vertices.end(),
                             [&](const Vertex& v) { return lightVertices.anyWithin(v.si.p); });
    }

    void pay(size_t lane, const EyeSubpath& e, double weight) const {
        Weighted& w = weighted[lane];
        const double scale = count * weight;
        SobolStream nee(hashKey(neeKey, lane), w.count++);
        Rgb sum = e.hit;
        for (const Vertex& v : e.vertices) sum += pass.estimateDirect(v, nee).value;
        if (!isBlack(sum)) film.addSplats({{{e.pixel, sum}}, {}}, scale);
        if (e.vertices.empty()) return;
        for (Vertex v : e.vertices) {
            v.throughput *= static_cast<float>(scale);
            w.vertices.push_back(v);
        }
        w.pixels.push_back(e.pixel);
        w.ends.push_back(w.vertices.size());
    }
};

EyeChains::EyeChains(const ReplicaSettings& settings, const FilmWindow& window)
    : order_(hilbertOrder(window.width, window.height)),
      rank_(order_.size()),
      lanes_([&] {
          ReplicaSettings s = settings;
          s.seed = hashKey(settings.seed, StreamPurpose::EyeChain);
          return s;
      }()),
      weighted_(lanes_.size()) {
    for (size_t i = 0; i < order_.size(); ++i) rank_[order_[i]] = static_cast<uint32_t>(i);
}

void EyeChains::begin(size_t samples, double radius) {
    squaredRadius_ = radius * radius;
    lanes_.normalization().update(squaredRadius_);
    mix_ = lanes_.mixture(samples, lanes_.normalization().visibleSamples() >= kVisibleSamples);
    if (mix_.uniform > 0) mix_.invisibleWeight = 1 / mix_.uniform;
}

void EyeChains::run(const EyePass& pass, const VertexGrid& lightVertices, Film& film,
                    const LightSubpathIteration& iteration, EyeVertices& result) {
    for (Weighted& w : weighted_) w = {};
    const uint64_t key = hashKey(lanes_.settings().seed, iteration.pass, iteration.first);
    const std::vector<uint32_t> strata = shuffled(static_cast<size_t>(mix_.uniform), key);
    Model model{pass, lightVertices, film, order_, double(iteration.count), strata, key, weighted_};
    lanes_.run(model, mix_, iteration.pass, iteration.first);
    lanes_.endIteration(squaredRadius_);
    gather(result);
}

void EyeChains::gather(EyeVertices& result) const {
    struct Subpath {
        uint32_t rank;
        std::span<const Vertex> vertices;
    };
    std::vector<Subpath> subpaths;
    for (const Weighted& w : weighted_)
        for (size_t i = 0, begin = 0; i < w.ends.size(); begin = w.ends[i++])
            subpaths.push_back({rank_[w.pixels[i]], {w.vertices.data() + begin, w.ends[i] - begin}});
    std::stable_sort(subpaths.begin(), subpaths.end(),
                     [](const Subpath& a, const Subpath& b) { return a.rank < b.rank; });
    result.clear();
    for (const Subpath& s : subpaths) result.append(s.vertices);
}

nlohmann::json EyeChains::statistics() const {
    return replicaStatistics(lanes_.settings(), lanes_.counts(), lanes_.normalization());
}

}  // namespace metrolux::core
