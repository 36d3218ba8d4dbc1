#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace metrolux::core {

/// Bytes of memory that this machine has; 0 if the system does not say.
uint64_t physicalMemoryBytes();
/// The largest resident set of this process so far, in bytes.
uint64_t peakMemoryBytes();
/// "1.5 GiB", for messages.
std::string sizeText(uint64_t bytes);

/// Bound for what the data of a scene may take. Files decide how much that is, so that their readers ask here
/// before they allocate: without, a file of a few bytes could have the system end the process.
class MemoryBudget {
  public:
    explicit MemoryBudget(uint64_t bytes) : total_(bytes) {}
    /// No bound.
    static MemoryBudget unlimited() { return MemoryBudget(~uint64_t{0}); }

    /// Throws Error if `bytes` more for `what` ("the vertices") do not fit.
    void require(uint64_t bytes, std::string_view what) const;
    /// The same, and books them as used for good.
    void take(uint64_t bytes, std::string_view what) {
        require(bytes, what);
        used_ += bytes;
    }
    uint64_t left() const { return total_ - used_; }

  private:
    uint64_t total_, used_ = 0;
};

}  // namespace metrolux::core
