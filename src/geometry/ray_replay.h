#pragma once
#include "geometry/intersector.h"
#include "geometry/ray_recorder.h"

#include <span>
#include <variant>
#include <vector>

namespace metrolux::core {

/// Asks again what a RayRecorder has recorded and does nothing with the answers: what tracing rays alone
/// costs. What an order needs is prepared by the constructor, so that run() does nothing but trace.
class RayReplay {
  public:
    enum class Order {
        /// The same calls: the same batches with the same flags, and single rays, in the order of their
        /// thread.
        AsCalled,
        /// All rays in full packets, sorted by the octant of their direction and by their origin along a
        /// Morton curve. No renderer can do that, as a ray is known when the one before it has been traced:
        /// with Order::AsCalled where that is faster, the limit of what tracing can cost.
        Sorted
    };
    RayReplay(const Intersector& intersector, const RayRecorder& recorder, Order order);

    /// In pieces, which threads of the caller's arena take.
    void run();
    /// How many answers of the last run() differ from the recorded ones: none, on the scene that they were
    /// recorded on.
    size_t different() const;

  private:
    struct Single {
        RecordedRay recorded;
        bool hit = false;
    };
    static void makeRoom(RayBatch& batch) {
        batch.hits.resize(batch.size());
        batch.localRays.resize(batch.size());
    }
    static void makeRoom(OcclusionBatch& batch) { batch.blocked.resize(batch.size()); }
    template <class Batch>
    struct Together {
        Batch batch;
        std::vector<uint8_t> recorded;  ///< answers
        Coherence coherence;

        Together(std::span<const RecordedRay> rays, Coherence together) : coherence(together) {
            for (const RecordedRay& r : rays) {
                batch.rays.push_back(r.ray);
                recorded.push_back(r.hit);
            }
            makeRoom(batch);
        }
    };
    using Call = std::variant<Single, Together<RayBatch>, Together<OcclusionBatch>>;
    struct Piece {
        std::vector<Call> calls;
        size_t rays = 0;
    };

    void take(const RecordedThread& thread);
    void sort(const RayRecorder& recorder);
    void add(Call call, size_t rays);
    /// Of one kind, and not none.
    void addBatch(std::span<const RecordedRay> rays, Coherence coherence);

    const Intersector& intersector_;
    std::vector<Piece> pieces_;
};

}  // namespace metrolux::core
