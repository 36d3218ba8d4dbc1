#include "geometry/ray_recorder.h"

#include "base/error.h"

namespace metrolux::core {

std::atomic<RayRecorder*> RayRecorder::active_{nullptr};

RayRecorder::Activity::Activity(RayRecorder& recorder) {
    RayRecorder* none = nullptr;
    if (!active_.compare_exchange_strong(none, &recorder)) throw Error("rays are being recorded already");
}

std::vector<std::span<const RecordedRay>> RayRecorder::byThread() const {
    std::vector<std::span<const RecordedRay>> result;
    for (const std::vector<RecordedRay>& rays : rays_) result.emplace_back(rays);
    return result;
}

}  // namespace metrolux::core
