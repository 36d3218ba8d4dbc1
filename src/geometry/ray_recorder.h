#pragma once
#include "geometry/ray_batch.h"

#include <tbb/enumerable_thread_specific.h>

#include <atomic>
#include <vector>

namespace metrolux::core {

/// A ray query and its answer.
struct RecordedRay {
    Ray ray;
    bool occlusion = false;  ///< Intersector::occluded, else intersect
    bool hit = false;
};

/// A call of the intersector: its rays follow those of the call before.
struct RecordedCall {
    size_t count = 1;
    bool batch = false;
    Coherence coherence = Coherence::Alone;  ///< of a batch
};

/// What a thread has asked, in its order.
struct RecordedThread {
    std::vector<RecordedRay> rays;
    std::vector<RecordedCall> calls;
};

/// Records all ray queries of the program during record(). Outside of it a query costs a load and a branch
/// more than without a recorder.
class RayRecorder {
  public:
    /// Runs the body and records its rays; those of an earlier call are forgotten. Throws Error when another
    /// recorder is at work.
    template <class Body>
    void record(Body&& body) {
        threads_.clear();
        const Activity activity(*this);
        body();
    }

    /// The recorder at work, if there is one.
    static RayRecorder* active() { return active_.load(std::memory_order_relaxed); }
    /// A call with one ray.
    void add(const RecordedRay& ray);
    void add(const RayBatch& batch, Coherence coherence);
    void add(const OcclusionBatch& batch, Coherence coherence);

    std::vector<const RecordedThread*> byThread() const;

  private:
    struct Activity {
        explicit Activity(RayRecorder& recorder);
        ~Activity() { active_.store(nullptr); }
        Activity(const Activity&) = delete;
        Activity& operator=(const Activity&) = delete;
    };
    static std::atomic<RayRecorder*> active_;
    tbb::enumerable_thread_specific<RecordedThread> threads_;
};

}  // namespace metrolux::core
