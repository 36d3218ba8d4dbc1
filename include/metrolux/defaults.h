#pragma once
#include <cstdint>

namespace metrolux {

// What holds where nothing is said, by the command and by the library alike.

inline constexpr const char* kDefaultIntegrator = "mcmc_vcm";
/// Bytes that an iteration may store. A fixed number, because the image depends on it: more memory of the
/// machine must not change it. Keeps 1920x1080 pixels of eight vertices each below 2.5 GB in all.
inline constexpr std::uint64_t kDefaultMemory = std::uint64_t{1408} << 20;
/// To render for, without any limit.
inline constexpr double kDefaultSeconds = 60;
/// Seconds between images of what is there so far, and between checkpoints.
inline constexpr double kDefaultSaveEvery = 60, kDefaultCheckpointEvery = 300;
/// That keeps black pixels from counting without limit in relMSE.
inline constexpr double kDefaultEpsilon = 1e-2;

}  // namespace metrolux
