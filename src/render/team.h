#pragma once
/// Processes that render one image together.

#include "geometry/intersector.h"
#include "image/film.h"
#include "render/slices.h"

#include <memory>
#include <string>
#include <vector>

namespace metrolux::core {

/// What the processes have rendered, summed; complete on rank 0, elsewhere only the flags are set.
struct TeamResult {
    std::vector<PixelSum> sums;
    std::vector<PixelHalf> halves;   ///< of the first half, if it is kept
    uint32_t firstPasses = 0;        ///< of the first half
    std::vector<SliceState> slices;  ///< of the other ranks, if they were asked for
    TechniqueCounts nonFinite{};
    RayStatistics rays;
    uint32_t passes = 0;
    bool working = false;      ///< whether a process has passes left
    bool interrupted = false;  ///< whether one was asked to stop
};

class Team {
  public:
    virtual ~Team() = default;
    virtual int rank() const = 0;
    virtual int size() const = 0;
    /// 0, 1, 2 ...: each number once, whoever asks.
    virtual uint32_t takeNumber() = 0;
    /// What a process brings to a meeting.
    struct Report {
        const Film& film;
        const HalfSums* halves;  ///< closed; null if they are not kept
        std::vector<SliceState> slices;
        TechniqueCounts nonFinite;
        RayStatistics rays;
        bool working = false, interrupted = false;
    };
    /// All processes call it, and wait for each other.
    virtual TeamResult meet(const Report& report) = 0;
    /// All processes call it. Throws Error on those whose text is not that of rank 0.
    virtual void checkSame(const std::string& text, const char* what) = 0;
    /// Ends all processes.
    virtual void abort(int status) = 0;
};

/// The processes that mpirun (or srun) has started with this one; null for a process alone. Throws Error when
/// there are several and the program was built without MPI.
std::unique_ptr<Team> makeTeam();

}  // namespace metrolux::core
