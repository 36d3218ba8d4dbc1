#pragma once
#include "base/math.h"

#include <array>
#include <atomic>
#include <cstdint>

namespace metrolux::core {

/// A way to make a path (docs/explain/algorithm.md, section 1).
enum class Technique : uint8_t { Hit, Nee, Connect, Splat, Merge };
inline constexpr size_t kTechniques = 5;
/// "hit", "nee" ...
const char* techniqueName(Technique technique);

/// A number for each technique, in their order.
using TechniqueCounts = std::array<uint64_t, kTechniques>;
TechniqueCounts& operator+=(TechniqueCounts& a, const TechniqueCounts& b);

/// Counts the contributions that are left out because they are not finite: a film would keep them for ever.
/// Passes ask it about each contribution, from many threads; sums do not depend on the order.
class NonFiniteCounts {
  public:
    /// True, and counted, if the contribution is not finite.
    bool reject(const Rgb& value, Technique technique) {
        if (isFinite(value)) return false;
        add(technique, 1);
        return true;
    }
    /// The value, or black in place of one that is rejected.
    Rgb finite(const Rgb& value, Technique technique) { return reject(value, technique) ? Rgb(0.0f) : value; }
    void add(Technique technique, uint64_t count) { counts_[static_cast<size_t>(technique)] += count; }
    /// So far.
    TechniqueCounts counts() const;

  private:
    std::array<std::atomic<uint64_t>, kTechniques> counts_{};
};

}  // namespace metrolux::core
