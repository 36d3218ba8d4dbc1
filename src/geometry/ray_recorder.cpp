#include "geometry/ray_recorder.h"

#include "base/error.h"

namespace metrolux::core {

std::atomic<RayRecorder*> RayRecorder::active_{nullptr};

RayRecorder::Activity::Activity(RayRecorder& recorder) {
    RayRecorder* none = nullptr;
    if (!active_.compare_exchange_strong(none, &recorder)) throw Error("rays are being recorded already");
}

void RayRecorder::add(const RecordedRay& ray) {
    RecordedThread& thread = threads_.local();
    thread.rays.push_back(ray);
    thread.calls.push_back({});
}

void RayRecorder::add(const RayBatch& batch, Coherence coherence) {
    RecordedThread& thread = threads_.local();
    for (size_t i = 0; i < batch.size(); ++i)
        thread.rays.push_back({batch.rays[i], false, batch.hits[i].found()});
    thread.calls.push_back({batch.size(), true, coherence});
}

void RayRecorder::add(const OcclusionBatch& batch, Coherence coherence) {
    RecordedThread& thread = threads_.local();
    for (size_t i = 0; i < batch.size(); ++i)
        thread.rays.push_back({batch.rays[i], true, batch.blocked[i] != 0});
    thread.calls.push_back({batch.size(), true, coherence});
}

std::vector<const RecordedThread*> RayRecorder::byThread() const {
    std::vector<const RecordedThread*> result;
    for (const RecordedThread& thread : threads_) result.push_back(&thread);
    return result;
}

}  // namespace metrolux::core
