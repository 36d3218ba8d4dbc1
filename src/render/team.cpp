#include "render/team.h"

#include "base/error.h"
#include "base/loaded_library.h"
#include "base/rng.h"
#include "base/state_archive.h"
#include "render/communicator.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>

namespace metrolux::core {
namespace {

/// Number of processes that a launcher says it has started: Open MPI, MPICH and its relatives, Slurm's srun
/// with PMIx or PMI2.
int launchedProcesses() {
    for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS"})
        if (const char* text = std::getenv(name)) return std::atoi(text);
    const char *slurm = std::getenv("SLURM_STEP_NUM_TASKS"), *pmix = std::getenv("PMIX_RANK");
    return slurm && pmix ? std::atoi(slurm) : 1;
}

class TeamOfRanks final : public Team {
  public:
    explicit TeamOfRanks(std::unique_ptr<Communicator> ranks) : ranks_(std::move(ranks)) {}
    int rank() const override { return ranks_->rank(); }
    int size() const override { return ranks_->size(); }
    uint32_t takeNumber() override { return ranks_->takeNumber(); }

    TeamResult meet(const Report& report) override {
        TeamResult result;
        result.working = ranks_->any(report.working);
        result.interrupted = ranks_->any(report.interrupted);
        sumFilm(report.film, result);
        if (report.halves) sumHalves(*report.halves, result);
        ranks_->sum(report.nonFinite.data(), result.nonFinite.data(), static_cast<int>(kTechniques));
        std::array<uint64_t, 2> rays{report.rays.intersectRays, report.rays.shadowRays}, allRays{};
        ranks_->sum(rays.data(), allRays.data(), 2);
        ranks_->sum(&report.rays.secondsInEmbree, &result.rays.secondsInEmbree, 1);
        result.rays.intersectRays = allRays[0];
        result.rays.shadowRays = allRays[1];
        gatherSlices(report.slices, result.slices);
        return result;
    }

    void checkSame(const std::string& text, const char* what) override {
        uint64_t size = text.size();
        ranks_->broadcast(&size, sizeof size);
        std::string expected = text;
        expected.resize(size);
        ranks_->broadcast(expected.data(), size);
        if (expected != text)
            throw Error("rank {}: found another {} than rank 0: {} instead of {}", rank(), what, text,
                        expected);
    }

    void abort(int status) override { ranks_->abort(status); }

  private:
    template <class Pixel>
    static void addPixels(const void* in, void* inOut, int count) {
        const auto* from = static_cast<const Pixel*>(in);
        auto* to = static_cast<Pixel*>(inOut);
        for (int i = 0; i < count; ++i) to[i] += from[i];
    }

    void sumFilm(const Film& film, TeamResult& result) const {
        const auto sums = film.sums();
        if (rank() == 0) result.sums.resize(sums.size());
        ranks_->sumRecords(sums.data(), result.sums.data(), static_cast<int>(sums.size()), sizeof(PixelSum),
                           &addPixels<PixelSum>);
        const uint32_t passes = film.passes();
        ranks_->sum(&passes, &result.passes, 1);
    }

    void sumHalves(const HalfSums& halves, TeamResult& result) const {
        const auto pixels = halves.pixels();
        if (rank() == 0) result.halves.resize(pixels.size());
        ranks_->sumRecords(pixels.data(), result.halves.data(), static_cast<int>(pixels.size()),
                           sizeof(PixelHalf), &addPixels<PixelHalf>);
        const uint32_t passes = halves.firstPasses();
        ranks_->sum(&passes, &result.firstPasses, 1);
    }

    /// One rank after the other, so that rank 0 holds one message at a time besides the result.
    void gatherSlices(const std::vector<SliceState>& own, std::vector<SliceState>& all) const {
        if (rank() != 0) {
            const std::string bytes = saveState(own);
            const uint64_t size = bytes.size();
            ranks_->send(&size, sizeof size);
            ranks_->send(bytes.data(), size);
            return;
        }
        for (int rank = 1; rank < size(); ++rank) {
            uint64_t size = 0;
            ranks_->receive(rank, &size, sizeof size);
            std::string bytes(size, '\0');
            ranks_->receive(rank, bytes.data(), size);
            std::vector<SliceState> slices;
            loadState(bytes, slices);
            std::move(slices.begin(), slices.end(), std::back_inserter(all));
        }
    }

    std::unique_ptr<Communicator> ranks_;
};

#ifdef METROLUX_MPI

std::unique_ptr<Communicator> loadCommunicator(int processes) {
    constexpr const char* kLibrary = "metrolux_mpi.so";
    // Global, since plugins of MPI look for its symbols there.
    void* const make = loadFunction(kLibrary, kMakeCommunicator, true);
    if (!make)
        throw Error(
            "started as one of {} processes of MPI, but {} is not beside this program: install the package "
            "metrolux-mpi, or divide the render with --only-slices and `metrolux merge`",
            processes, kLibrary);
    try {
        return std::unique_ptr<Communicator>(reinterpret_cast<MakeCommunicator>(make)());
    } catch (const std::runtime_error& error) {
        throw Error(error.what());
    }
}

#endif

}  // namespace

std::unique_ptr<Team> makeTeam() {
    const int processes = launchedProcesses();
    if (processes <= 1) return nullptr;
#ifdef METROLUX_MPI
    return std::make_unique<TeamOfRanks>(loadCommunicator(processes));
#else
    throw Error(
        "started as one of {} processes of MPI, but this program was built without MPI: install "
        "libopenmpi-dev "
        "and build again, or divide the render with --only-slices and `metrolux merge`",
        processes);
#endif
}

}  // namespace metrolux::core
