#pragma once
#include "base/math.h"

#include <tbb/enumerable_thread_specific.h>

#include <atomic>
#include <span>
#include <vector>

namespace metrolux::core {

/// A ray query and its answer.
struct RecordedRay {
    Ray ray;
    bool occlusion = false;  ///< Intersector::occluded, else intersect
    bool hit = false;
};

/// Records all ray queries of the program during record(), in the order in which each thread issues them.
/// Outside of it a query costs a load and a branch more than without a recorder.
class RayRecorder {
  public:
    /// Runs the body and records its rays; those of an earlier call are forgotten. Throws Error when another
    /// recorder is at work.
    template <class Body>
    void record(Body&& body) {
        rays_.clear();
        const Activity activity(*this);
        body();
    }

    /// The recorder at work, if there is one.
    static RayRecorder* active() { return active_.load(std::memory_order_relaxed); }
    void add(const RecordedRay& ray) { rays_.local().push_back(ray); }

    /// What was recorded, by thread.
    std::vector<std::span<const RecordedRay>> byThread() const;

  private:
    struct Activity {
        explicit Activity(RayRecorder& recorder);
        ~Activity() { active_.store(nullptr); }
        Activity(const Activity&) = delete;
        Activity& operator=(const Activity&) = delete;
    };
    static std::atomic<RayRecorder*> active_;
    tbb::enumerable_thread_specific<std::vector<RecordedRay>> rays_;
};

}  // namespace metrolux::core
