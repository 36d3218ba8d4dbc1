#include "integrators/iteration.h"

#include "base/parallel.h"
#include "sampling/streams.h"
#include "transport/medium_kernel.h"
#include "transport/subpath.h"
#include "wavefront/light_subpath_order.h"
#include "wavefront/light_subpath_wavefront.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

PixelPartition::PixelPartition(const FilmWindow& window, const CommonOptions& options) {
    const std::vector<uint32_t> order = hilbertOrder(window.width, window.height);
    if (options.memoryBytes > 0) {
        // Vertices with room to grow, and with their grid entries and bucket starts. While they are gathered
        // those of a group of tasks are there twice.
        const double verticesPerSubpath =
            options.limits.maxDepth < 0 ? 8 : std::clamp(options.limits.maxDepth, 1, 8);
        const double stored = verticesPerSubpath * (1.125 * sizeof(Vertex) + 32),
                     gathered = verticesPerSubpath * sizeof(Vertex), bytes = double(options.memoryBytes);
        const double group = double(EyeWavefronts::kGroup);
        const double pixels =
            std::max(std::min(bytes / (stored + gathered), group), (bytes - group * gathered) / stored);
        parts_ =
            static_cast<int>(std::clamp(std::ceil(double(order.size()) / pixels), 1.0, double(order.size())));
    }
    pixels_.reserve(order.size());
    for (int part = 0; part < parts_; ++part) {
        starts_.push_back(pixels_.size());
        for (size_t i = part; i < order.size(); i += parts_) pixels_.push_back(order[i]);
    }
    starts_.push_back(pixels_.size());
}

namespace {

/// Follows an eye subpath to the first vertex that is sought, if light can be joined with none before, and
/// notes the way.
class FirstSought final : public SubpathVisitor {
  public:
    using IsSought = bool (*)(const Vertex&);
    explicit FirstSought(IsSought isSought) : isSought_(isSought) {}
    double traveled = 0;
    double lastEdge = 0;  ///< length of the last edge on the way
    bool found = false;
    bool surface(const Vertex& v) override {
        lastEdge = v.distanceToPrevious;
        traveled += lastEdge;
        found = isSought_(v);
        return !found && !v.hasSmoothLobe() && v.depth < 16;
    }

  private:
    IsSought isSought_;
};

/// Mean of radiusOf(footprint, visitor) over eye subpaths that find what is sought, 0 if none does.
/// `footprint`: of a pixel at that distance.
template <class RadiusOf>
double meanOverProbes(const Scene& scene, const PathLimits& limits, uint64_t key,
                      FirstSought::IsSought isSought, RadiusOf&& radiusOf) {
    constexpr int kProbes = 4096;
    const FilmWindow& w = scene.camera().window();
    double sum = 0;
    int count = 0;
    for (int i = 0; i < kProbes; ++i) {
        SobolStream stream(hashKey(key, i / 64), static_cast<uint32_t>(i));
        const Vec2f u = read(stream, layout::kRaster);
        FirstSought visitor(isSought);
        traceEyeSubpath(scene, stream, limits, Strategies::path(),
                        Vec2f(w.x + u.x * w.width, w.y + u.y * w.height), 1, 0, visitor);
        if (!visitor.found) continue;
        sum += radiusOf(scene.camera().pixelFootprint(static_cast<float>(visitor.traveled)), visitor);
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

}  // namespace

double projectedPixelRadius(const Scene& scene, const PathLimits& limits) {
    constexpr double kFallbackFraction = 0.003;  // of the scene's radius
    const double footprint = meanOverProbes(
        scene, limits, 0x726164697573, [](const Vertex& v) { return v.hasSmoothLobe(); },
        [](double width, const FirstSought&) { return width; });
    return footprint > 0 ? footprint : kFallbackFraction * scene.bounds().radius;
}

double projectedMediumRadius(const Scene& scene, const PathLimits& limits) {
    constexpr double kNearInMedia = 10, kOfFlight = 0.25;
    if (!scene.hasMedia()) return 0;
    return meanOverProbes(
        scene, limits, 0x6d6564, [](const Vertex& v) { return v.inMedium; },
        [](double width, const FirstSought& visitor) {
            const double flight = visitor.lastEdge;
            return std::min(std::cbrt(kNearInMedia * 0.75 / std::numbers::pi * width * width * flight),
                            kOfFlight * flight);
        });
}

void checkRadius(double radius, const Scene& scene) {
    constexpr double kFinest =
        0x1p-26;  // a quarter of a unit in the last place, at the distance of the radius
    const double size = double(scene.bounds().radius);
    if (!(radius <= size && radius >= kFinest * size))
        throw Error(
            "merging radius {:g}: found a scene of radius {:.3g}, expected {:.1g} to {:.3g} scene units",
            radius, size, kFinest * size, size);
}

void directPass(const EyePass& pass, std::span<const uint32_t> pixels, Film& film) {
    PathLimits oneEdge = pass.limits;
    oneEdge.maxDepth = 1;
    Strategies strategies = Strategies::hitsAlone();
    strategies.wavelength = wavelengthOf(pass.scene, pass.seed, pass.pass);
    EyeVertices none;
    EyeWavefronts().run({pass.scene, oneEdge, strategies, pass.nonFinite, pass.seed, pass.pass}, pixels, film,
                        none);
}

uint64_t lightSubpathKey(uint64_t seed, uint32_t pass, size_t index) {
    return hashKey(seed, StreamPurpose::LightSubpath, pass, index);
}

void independentLightSubpaths(const LightSubpathPass& pass, Film& film, uint64_t seed,
                              const LightSubpathIteration& iteration, PhotonDensity* counted,
                              std::vector<double>* sizes) {
    constexpr size_t kChunk = 256;
    const size_t count = iteration.count;
    const double scale = 1.0 / double(count);
    if (sizes) sizes->assign(count, 0);
    const auto streamOf = [&](size_t i) {
        return IndependentStream(lightSubpathKey(seed, iteration.pass, iteration.first + i));
    };
    const std::vector<uint32_t> order = coherentOrder(pass.rules(), count, streamOf);
    parallelFor((count + kChunk - 1) / kChunk, [&](size_t chunk) {
        const std::span<const uint32_t> subpaths =
            std::span(order).subspan(chunk * kChunk, std::min(count - chunk * kChunk, kChunk));
        const size_t n = subpaths.size();
        static thread_local std::vector<SplatList> splats(kChunk);  // keep their memory
        std::vector<IndependentStream> streams;
        std::vector<LightSubpathJob> jobs;
        streams.reserve(n);
        for (size_t i = 0; i < n; ++i) {
            streams.push_back(streamOf(subpaths[i]));
            jobs.push_back({&streams[i], &splats[i], counted});
        }
        evaluateTogether(pass, jobs, Coherence::None);
        for (size_t i = 0; i < n; ++i) {
            if (splats[i].empty()) continue;
            film.addSplats(splats[i], scale, scale * iteration.filmShare);
            if (sizes) (*sizes)[subpaths[i]] = sizeOf(splats[i], iteration.target);
        }
    });
}

int laneCount(const ChainParameters& chains, size_t steps) {
    constexpr size_t kStepsPerLane = 1024, kFewest = 8, kMost = 64;
    if (chains.lanes > 0) return chains.lanes;
    return static_cast<int>(std::clamp(steps / kStepsPerLane, kFewest, kMost));
}

IteratedIntegrator::IteratedIntegrator(const Scene& scene, const CommonOptions& options,
                                       const MergingParameters& merging)
    : scene_(scene),
      options_(options),
      partition_(scene.camera().window(), options),
      radius_(merging.radius, merging.alpha),
      firstRadius_(merging.radius) {}

/// Its cube shrinks as the square of the other.
double IteratedIntegrator::mediumRadius() const {
    return firstRadius_ > 0 ? firstMediumRadius_ * std::cbrt(sqr(radius_.radius() / firstRadius_)) : 0;
}

void IteratedIntegrator::countMerges(double samples, Strategies& strategies) const {
    const double r = radius_.radius(), inMedia = mediumRadius();
    strategies.merge = samples * std::numbers::pi * r * r;
    if (r > 0) strategies.mergeInMedia = 4.0 / 3.0 * inMedia * inMedia * inMedia / (r * r);
}

void IteratedIntegrator::sortEyes() {
    const PointSpan positions = positionsOf(eyes_.all());
    const auto r = static_cast<float>(radius_.radius());
    if (!scene_.hasMedia()) return grid_.build(positions, r);
    std::vector<uint32_t> onSurfaces, inMedia;
    for (size_t i = 0; i < eyes_.vertices.size(); ++i)
        (eyes_.vertices[i].inMedium ? inMedia : onSurfaces).push_back(static_cast<uint32_t>(i));
    grid_.build(positions, onSurfaces, r);
    if (!(firstMediumRadius_ > 0) || inMedia.empty()) return mediumGrid_.clear();
    const auto rMedium = static_cast<float>(mediumRadius());
    mediumGrid_.build(positions, inMedia, rMedium);
    shareInside_.assign(eyes_.vertices.size(), 1);
    parallelFor(inMedia.size(), [&](size_t i) {
        shareInside_[inMedia[i]] = shareInside(scene_, eyes_.vertices[inMedia[i]], rMedium);
    });
}

void IteratedIntegrator::weighByVariance(const VarianceParameters& variance) {
    if (variance.varianceAware) eyeFactors_ = std::make_unique<EyeFactors>(scene_.camera().window());
}

void IteratedIntegrator::weighByPhotons(const WeighingParameters& weighing) {
    if (weighing.correlationAware) photons_ = std::make_unique<PhotonDensity>(kPhotonCell * radius_.radius());
}

void IteratedIntegrator::addPass(Film& film, uint32_t pass) {
    size_t first = 0;
    for (int part = 0; part < partition_.parts(); ++part) {
        iterate(film, pass, partition_.pixels(part), first);
        first += partition_.pixels(part).size();
    }
    if (eyeFactors_) eyeFactors_->endPass();
    endPass(film);
    radius_.advance();
}

nlohmann::json IteratedIntegrator::iterationStatistics() const {
    nlohmann::json j{
        {"parts", partition_.parts()},
        {"bytes_per_vertex", sizeof(Vertex)},
        {"stored_bytes", eyes_.memoryBytes() + eyeWavefronts_.memoryBytes() + grid_.memoryBytes()}};
    if (radius_.radius() > 0) j["radius"] = radius_.radius();
    if (eyeFactors_) j["eye_factors"] = {eyeFactors_->mean(1), eyeFactors_->mean(2), eyeFactors_->mean(3)};
    return j;
}

}  // namespace metrolux::core
