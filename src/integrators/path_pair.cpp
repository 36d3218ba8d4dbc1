#include "integrators/path_pair.h"

#include "sampling/streams.h"
#include "transport/connect.h"
#include "transport/eye_pass.h"
#include "transport/light_subpath_pass.h"
#include "transport/subpath.h"

namespace metrolux::core {

namespace {

/// Follows a subpath to its vertex after `depth` edges.
class VertexAt final : public SubpathVisitor {
  public:
    explicit VertexAt(int depth) : depth_(depth) {}
    const std::optional<Vertex>& vertex() const { return vertex_; }
    bool canConnect() const { return vertex_ && vertex_->hasSmoothLobe(); }

    bool surface(const Vertex& v) override {
        if (v.depth < depth_) return true;
        vertex_ = v;
        return false;
    }

  private:
    int depth_;
    std::optional<Vertex> vertex_;
};

/// Radiance of the emitter that an eye subpath meets with its edge number `depth`.
class EmitterAt final : public SubpathVisitor {
  public:
    EmitterAt(const Scene& scene, const Strategies& strategies, int depth)
        : scene_(scene), strategies_(strategies), depth_(depth) {}
    const Rgb& value() const { return value_; }

    bool surface(const Vertex& v) override {
        if (v.depth < depth_) return true;
        if (v.emitter()) value_ = hitLight(scene_, strategies_, v).value;
        return false;
    }
    void escaped(const Vec3f& from, const WalkEdge& edge, int depth) override {
        if (depth == depth_) value_ = hitEnvironment(scene_, strategies_, from, edge, depth).value;
    }

  private:
    const Scene& scene_;
    const Strategies& strategies_;
    int depth_;
    Rgb value_{0.0f};
};

/// The samples of the eye subpath, the light subpath and next-event estimation, which take turns.
struct Streams {
    InterleavedStream eye, light, nee;
    explicit Streams(SampleStream& u)
        : eye(u, layout::kEyeStream, layout::kStreams),
          light(u, layout::kLightStream, layout::kStreams),
          nee(u, layout::kNeeStream, layout::kStreams) {}
};

}  // namespace

void PathPair::addSplat(const Vec2f& raster, const Rgb& value, Technique technique, SplatList& splats) const {
    if (nonFinite.reject(value, technique) || isBlack(value) || !film.reach().contains(raster)) return;
    splats.film.push_back({raster, value});
}

Strategies PathPair::strategiesOf(SampleStream& eye) const {
    Strategies result = strategies;
    if (scene.hasDispersion() && !result.wavelength.isGiven())
        result.wavelength = Wavelength::at(double(read(eye, layout::kWavelength)));
    return result;
}

void PathPair::all(SampleStream& u, SplatList& splats) const {
    splats.clear();
    Streams streams(u);
    const Strategies counts = strategiesOf(streams.eye);
    const Vec2f raster = film.reach().at(read(streams.eye, layout::kRaster));
    PathLimits indirect = limits;
    indirect.minDepth = 2;
    const EyePass eyePass{scene, indirect, counts, nonFinite};
    thread_local std::vector<Vertex> eye;  // keeps its memory
    eye.clear();
    Rgb sum = eyePass.trace(streams.eye, &streams.nee, raster, film.reach().area(), 0, eye).value;

    if (photons)
        for (const Vertex& v : eye) {
            const Rgb merged = photons->merge(scene, counts, v, limits.maxDepth);
            if (!nonFinite.reject(merged, Technique::Merge)) sum += merged;
        }

    const EyeVertices none;
    const VertexGrid noGrid;
    const LightSubpathPass lightPass{scene, limits, counts, none, noGrid, nonFinite};
    lightPass.evaluate({&streams.light, &splats}, {eye, 1});
    // Connections belong to the eye subpath's raster position, as hit and nee do.
    for (const SplatList::PixelSplat& connection : splats.pixels) sum += connection.value;
    splats.pixels.clear();
    const RasterRectangle reach = film.reach();
    std::erase_if(splats.film, [&](const auto& splat) { return !reach.contains(splat.position); });
    addSplat(raster, sum, Technique::Connect, splats);
}

void PathPair::one(int length, SampleStream& u, SplatList& splats) const {
    splats.clear();
    Streams streams(u);
    const Strategies counts = strategiesOf(streams.eye);
    Vec2f raster = film.reach().at(read(streams.eye, layout::kRaster));
    // (s, t) with s light vertices and t = length + 1 - s >= 1 eye vertices, the camera among them.
    const int techniques = length + 1;
    const int s = std::min(
        static_cast<int>(read(streams.eye, layout::kTechnique) * static_cast<float>(techniques)), length);
    const int t = length + 1 - s;
    const auto add = [&](const Rgb& value, Technique technique) {
        addSplat(raster, value * static_cast<float>(techniques), technique, splats);
    };

    VertexAt light(s - 1), eye(t - 1);
    if (s >= 2) {
        traceLightSubpath(scene, streams.light, limits, counts, light);
        if (!light.canConnect()) return;
    }
    if (t == 1) {
        const Vec2f uLens = read(streams.light, layout::kSplatLens);
        const Rgb value = connectToCamera(scene, counts, *light.vertex(), uLens, raster).value;
        return add(value, Technique::Splat);
    }
    const float area = film.reach().area();
    if (s == 0) {
        EmitterAt emitter(scene, counts, length);
        traceEyeSubpath(scene, streams.eye, limits, counts, raster, area, 0, emitter);
        return add(emitter.value(), Technique::Hit);
    }
    traceEyeSubpath(scene, streams.eye, limits, counts, raster, area, 0, eye);
    if (!eye.canConnect()) return;
    if (s == 1) {
        add(EyePass{scene, limits, counts, nonFinite}.estimateDirect(*eye.vertex(), streams.nee).value,
            Technique::Nee);
    } else {
        add(connectVertices(scene, counts, *light.vertex(), *eye.vertex()).value, Technique::Connect);
    }
}

}  // namespace metrolux::core
