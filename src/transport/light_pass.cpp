#include "transport/light_pass.h"

#include "base/prefetch.h"
#include "transport/connect.h"
#include "transport/subpath.h"

#include <array>
#include <bit>
#include <utility>

namespace metrolux {

namespace {

/// Vertices of an eye subpath that are asked for before the light subpath is traced.
constexpr size_t kPrefetched = 4;

class LightVisitor final : public SubpathVisitor {
  public:
    LightVisitor(const LightPass& pass, std::span<const Vertex> partner, float connectionScale,
                 const Vec2f& uLens, SplatList& splats, PhotonDensity* counted, std::vector<Vec3f>* trail)
        : pass_(pass),
          partner_(partner),
          connectionScale_(connectionScale),
          uLens_(uLens),
          splats_(splats),
          counted_(counted),
          trail_(trail) {
        const float r = pass.grid.radius();
        inverseDiskArea_ = 1.0 / (double(kPi) * r * r);
    }

    ~LightVisitor() override {
        if (!pass_.work) return;
        pass_.work->splats += splatsTried_;
        pass_.work->connections += connectionsTried_;
        pass_.work->merges += mergesFound_;
    }
    LightVisitor(const LightVisitor&) = delete;
    LightVisitor& operator=(const LightVisitor&) = delete;

    bool surface(const Vertex& v) override {
        const int limit = depthLimit();
        lookForMerges();
        const bool smooth = v.bsdf().hasSmoothLobe(), merges = smooth && pass_.merge && !pass_.grid.empty();
        VertexGrid::Cells cells;
        if (merges) cells = pass_.grid.locate(v.si.p);
        if (smooth) {
            if (counted_) counted_->count(v.si.p);
            if (trail_) trail_->push_back(v.si.p);
            if (pass_.splat && v.depth < limit) splat(v);
        }
        mergeFound();
        if (smooth && pass_.connect) connect(v, limit);
        if (merges) {
            merging_ = v;
            cells_ = cells;
            waiting_ = true;
        }
        return v.depth + 1 < limit;
    }

    bool scattered(bool) override {
        if (waiting_) pass_.grid.prefetchEntries(cells_);
        return true;
    }

    /// The walk has ended.
    void finish() {
        lookForMerges();
        mergeFound();
    }

  private:
    void splat(const Vertex& v) {
        ++splatsTried_;
        Vec2f raster;
        const Rgb value = connectToCamera(pass_.scene, pass_.strategies, v, uLens_, pass_.weighted, raster);
        if (!pass_.film.rejectNonFinite(value, Technique::Splat) && !isBlack(value))
            splats_.film.push_back({raster, value});
    }

    void connect(const Vertex& v, int limit) {
        for (const Vertex& eye : partner_) {
            if (v.depth + eye.depth + 1 > limit) break;
            ++connectionsTried_;
            addPixel(eye.pixel, connectVertices(pass_.scene, pass_.strategies, v, eye) * connectionScale_,
                     Technique::Connect);
        }
    }

    // Merging waits for memory three times: for the cells around the light vertex, for their entries, and for
    // the eye vertices. In between the walk goes on: cells are located before the vertex is connected with
    // the camera, entries are asked for before the next ray is traced, eye vertices before the next vertex is
    // connected.
    void lookForMerges() {
        if (!std::exchange(waiting_, false)) return;
        const Vertex* const eyes = pass_.eyes.all().data();
        pass_.grid.query(merging_.si.p, cells_, [&](uint32_t index) {
            if (foundCount_ == found_.size()) mergeFound();
            prefetch(eyes + index, sizeof(Vertex));
            found_[foundCount_++] = index;
        });
    }

    void mergeFound() {
        const Vertex* const eyes = pass_.eyes.all().data();
        const int limit = depthLimit();
        for (size_t i = 0; i < foundCount_; ++i) {
            const Vertex& eye = eyes[found_[i]];
            if (merging_.depth + eye.depth > limit) continue;
            ++mergesFound_;
            addPixel(eye.pixel,
                     mergeVertices(pass_.strategies, merging_, eye, inverseDiskArea_, pass_.weighted),
                     Technique::Merge);
        }
        foundCount_ = 0;
    }

    int depthLimit() const {
        return pass_.limits.maxDepth < 0 ? std::numeric_limits<int>::max() / 2 : pass_.limits.maxDepth;
    }

    void addPixel(uint32_t pixel, const Rgb& value, Technique technique) {
        if (!pass_.film.rejectNonFinite(value, technique) && !isBlack(value))
            splats_.pixels.push_back({pixel, value});
    }

    const LightPass& pass_;
    std::span<const Vertex> partner_;
    float connectionScale_;
    Vec2f uLens_;
    SplatList& splats_;
    PhotonDensity* counted_;
    std::vector<Vec3f>* trail_;
    double inverseDiskArea_;
    Vertex merging_;  ///< whose merges are looked for, while `waiting_`
    VertexGrid::Cells cells_;
    bool waiting_ = false;
    std::array<uint32_t, 32> found_;  ///< eye vertices to merge `merging_` with
    size_t foundCount_ = 0;
    uint64_t splatsTried_ = 0, connectionsTried_ = 0, mergesFound_ = 0;
};

/// Distance along the Hilbert curve that fills a 2^order square (the classic quadrant walk).
uint64_t hilbertDistance(int order, uint32_t x, uint32_t y) {
    uint64_t d = 0;
    for (uint32_t s = 1u << (order - 1); s > 0; s >>= 1) {
        const uint32_t rx = (x & s) ? 1 : 0, ry = (y & s) ? 1 : 0;
        d += uint64_t(s) * s * ((3 * rx) ^ ry);
        if (ry == 0) {
            if (rx == 1) {
                x = (s - 1) - (x & (s - 1));
                y = (s - 1) - (y & (s - 1));
            }
            std::swap(x, y);
        }
        x &= s - 1;
        y &= s - 1;
    }
    return d;
}

}  // namespace

Vec2f LightPass::lensCoordinates(SampleStream& stream) {
    stream.seek(0);
    stream.skip(kLensCoordinate);
    return stream.next2D();
}

void LightPass::evaluate(SampleStream& stream, SplatList& splats, PhotonDensity* counted,
                         std::vector<Vec3f>* trail) const {
    splats.clear();
    if (trail) trail->clear();
    stream.seek(0);
    stream.skip(kEyeSubpathCoordinate);
    const float uEye = stream.next1D();
    // One eye subpath of N is picked, by a share of the light subpaths: its pixel's share stands for all.
    std::span<const Vertex> partner;
    const double share = strategies.connect;
    if (connect && eyes.subpathCount() > 0 && double(uEye) < share) {
        const size_t n = eyes.subpathCount();
        partner = eyes.subpath(std::min(static_cast<size_t>(double(uEye) / share * double(n)), n - 1));
        prefetch(partner.data(), std::min(partner.size(), kPrefetched) * sizeof(Vertex));
    }
    trace(stream, partner, static_cast<float>(double(eyes.subpathCount()) / share), splats, counted, trail);
}

void LightPass::trace(SampleStream& stream, std::span<const Vertex> partner, float connectionScale,
                      SplatList& splats, PhotonDensity* counted, std::vector<Vec3f>* trail) const {
    LightVisitor visitor(*this, partner, connectionScale, lensCoordinates(stream), splats, counted, trail);
    traceLightSubpath(scene, stream, limits, strategies, visitor);
    visitor.finish();
}

std::vector<uint32_t> hilbertOrder(int width, int height) {
    const int order =
        std::max(1, static_cast<int>(std::bit_width(static_cast<uint32_t>(std::max(width, height) - 1))));
    std::vector<std::pair<uint64_t, uint32_t>> keyed;
    keyed.reserve(size_t(width) * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            keyed.emplace_back(hilbertDistance(order, x, y), static_cast<uint32_t>(y * width + x));
    std::sort(keyed.begin(), keyed.end());
    std::vector<uint32_t> result;
    result.reserve(keyed.size());
    for (const auto& [distance, pixel] : keyed) result.push_back(pixel);
    return result;
}

}  // namespace metrolux
