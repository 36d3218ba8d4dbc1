#include "transport/light_subpath_pass.h"

#include "transport/connect.h"
#include "transport/merge_walls.h"
#include "transport/subpath.h"

namespace metrolux::core {

namespace {

/// Merges, splats and connects the vertices of a light subpath.
class LightSubpathVisitor final : public SubpathVisitor {
  public:
    LightSubpathVisitor(const LightSubpathPass& pass, const LightSubpathJob& job,
                        const LightSubpathPass::Partner& partner)
        : pass_(pass), job_(job), partner_(partner), uLens_(read(*job.stream, layout::kSplatLens)) {}

    bool surface(const Vertex& v) override {
        if (v.hasSmoothLobe()) {
            if (job_.counted && !v.inMedium) job_.counted->count(v.si.p);
            if (job_.trail && !v.inMedium) job_.trail->push_back(v.si.p);
            if (const VertexGrid* grid = pass_.gridFor(v)) merge(v, *grid);
            if (pass_.strategies.splat > 0) splat(v);
            connect(v);
        }
        return pass_.extensible(v, 2);
    }

  private:
    void merge(const Vertex& v, const VertexGrid& grid) {
        const double kernel = LightSubpathPass::kernelOf(grid, v.inMedium);
        grid.query(v.si.p, [&](uint32_t index) {
            const Vertex& eye = pass_.eyes.vertices[index];
            if (pass_.limits.admits(v.depth + eye.depth)) pass_.merge(v, index, kernel, *job_.splats);
        });
    }
    void splat(const Vertex& v) {
        if (!pass_.limits.admits(v.depth + 1)) return;
        Vec2f raster;
        const LightFinding found = connectToCamera(pass_.scene, pass_.strategies, v, uLens_, raster);
        pass_.addToFilm(raster, found, *job_.splats);
    }
    void connect(const Vertex& v) {
        for (const Vertex& eye : partner_.vertices)
            if (pass_.limits.admits(v.depth + eye.depth + 1)) {
                LightFinding found = connectVertices(pass_.scene, pass_.strategies, v, eye);
                found.value *= partner_.scale;
                pass_.addPixel(eye.pixel, found, Technique::Connect, *job_.splats);
            }
    }

    const LightSubpathPass& pass_;
    const LightSubpathJob& job_;
    const LightSubpathPass::Partner& partner_;
    Vec2f uLens_;
};

}  // namespace

LightSubpathPass::Partner LightSubpathPass::choosePartner(SampleStream& stream) const {
    const double u = read(stream, layout::kEyeSubpath), share = strategies.connect;
    const size_t n = eyes.subpathCount();
    if (n == 0 || !(u < share)) return {};
    return {eyes.subpath(std::min(static_cast<size_t>(u / share * double(n)), n - 1)),
            static_cast<float>(double(n) / share)};
}

void LightSubpathPass::merge(const Vertex& light, uint32_t index, double kernel, SplatList& splats) const {
    const Vertex& eye = eyes.vertices[index];
    const LightFinding found =
        light.inMedium ? mergeInMedium(strategies, light, eye, kernel / double(shareInside[index]))
                       : mergeVertices(strategies, light, eye, kernel);
    if (isBlack(found.value)) return;
    const bool wall = light.inMedium ? !scene.visible(light.si.p, Vec3f(0.0f), eye.si.p, Vec3f(0.0f))
                                     : isWallBetween(scene, light, eye, grid.radius());
    if (!wall) addPixel(eye.pixel, found, Technique::Merge, splats);
}

void LightSubpathPass::evaluate(const LightSubpathJob& job) const {
    evaluate(job, choosePartner(*job.stream));
}

void LightSubpathPass::evaluate(const LightSubpathJob& job, const Partner& partner) const {
    job.splats->clear();
    if (job.trail) job.trail->clear();
    LightSubpathVisitor visitor(*this, job, partner);
    traceLightSubpath(scene, *job.stream, limits, strategies, visitor);
}

}  // namespace metrolux::core
