#pragma once
#include "geometry/ray_batch.h"
#include "transport/connect.h"
#include "transport/light_pass.h"
#include "transport/walk.h"

#include <vector>

namespace metrolux::core {

/// Light subpaths of a LightPass side by side, as EyeWave has eye subpaths: rays are traced together, and
/// memory that one waits for is asked for while others are at work. What a subpath contributes, and the order
/// in which it does, depends on its own job only.
class LightWave {
  public:
    void run(const LightPass& pass, std::span<const LightJob> jobs, Coherence coherence);
    /// One subpath, whose eye subpath is given (LightPass::trace).
    void run(const LightPass& pass, const LightJob& job, std::span<const Vertex> partner,
             float connectionScale);

  private:
    struct Lane {
        LightJob job;
        std::span<const Vertex> partner;
        float connectionScale = 1;
        Vec2f uLens;
        Vertex v;
        WalkEdge edge;
        VertexGrid::Cells cells;
        PhotonDensity::Bucket counted = 0;
        bool smooth = false, merges = false;  ///< at the last vertex
        size_t nearEnd = 0;                   ///< where its own end in near_
    };
    /// A connection of a lane that waits for its shadow ray.
    struct Waiting {
        uint32_t lane;
        uint32_t pixel;
        Vec2f raster;
        Rgb value;
    };

    void begin(const LightPass& pass, std::span<const LightJob> jobs, Coherence coherence);
    void choosePartner(Lane& lane) const;
    void trace();
    void start();
    void arrive(int depth);
    void prepare();
    void splat(int depth);
    void connect(int depth);
    void traceShadows();
    void merge(int depth);
    void scatter(int depth);
    void addPixel(const Lane& lane, uint32_t pixel, const Rgb& value, Technique technique) const;

    const LightPass* pass_ = nullptr;  ///< during run()
    Coherence coherence_ = Coherence::None;
    int limit_ = 0;  ///< edges of a path
    std::vector<Lane> lanes_;
    std::vector<LightStart> starts_;  ///< of each lane
    std::vector<uint32_t> active_;    ///< lanes on their way
    RayBatch rays_;                   ///< of active_
    OcclusionBatch shadows_;
    std::vector<Waiting> waiting_;  ///< of shadows_
    /// Eye vertices within the radius of the lanes' vertices, lane after lane.
    UninitializedVector<uint32_t> near_;
};

}  // namespace metrolux::core
