#include "render/team.h"

#include "base/error.h"
#include "base/rng.h"
#include "base/state_archive.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>

#ifdef METROLUX_MPI
#include <mpi.h>
#endif

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

#ifdef METROLUX_MPI

class MpiTeam final : public Team {
  public:
    MpiTeam() {
        int provided = 0;
        MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
        if (provided < MPI_THREAD_SERIALIZED)
            throw Error("MPI: found thread support {}, expected MPI_THREAD_SERIALIZED", provided);
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &size_);
        MPI_Type_contiguous(sizeof(PixelSum), MPI_BYTE, &pixelType_);
        MPI_Type_commit(&pixelType_);
        MPI_Op_create(&addPixels, 1, &pixelOp_);
        MPI_Win_allocate(rank_ == 0 ? sizeof(uint32_t) : 0, sizeof(uint32_t), MPI_INFO_NULL, MPI_COMM_WORLD,
                         &counter_, &window_);
        if (rank_ == 0) *counter_ = 0;
        MPI_Barrier(MPI_COMM_WORLD);
    }
    ~MpiTeam() override {
        MPI_Win_free(&window_);
        MPI_Op_free(&pixelOp_);
        MPI_Type_free(&pixelType_);
        MPI_Finalize();
    }
    int rank() const override { return rank_; }
    int size() const override { return size_; }

    uint32_t takeNumber() override {
        const uint32_t one = 1;
        uint32_t number = 0;
        MPI_Win_lock(MPI_LOCK_SHARED, 0, 0, window_);
        MPI_Fetch_and_op(&one, &number, MPI_UINT32_T, 0, 0, MPI_SUM, window_);
        MPI_Win_unlock(0, window_);
        return number;
    }

    TeamResult meet(const Report& report) override {
        TeamResult result;
        result.working = any(report.working);
        result.interrupted = any(report.interrupted);
        reduceFilm(report.film, result);
        MPI_Reduce(report.nonFinite.data(), result.nonFinite.data(), static_cast<int>(kTechniques),
                   MPI_UINT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
        std::array<uint64_t, 2> rays{report.rays.intersectRays, report.rays.shadowRays}, allRays{};
        MPI_Reduce(rays.data(), allRays.data(), 2, MPI_UINT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
        MPI_Reduce(&report.rays.secondsInEmbree, &result.rays.secondsInEmbree, 1, MPI_DOUBLE, MPI_SUM, 0,
                   MPI_COMM_WORLD);
        result.rays.intersectRays = allRays[0];
        result.rays.shadowRays = allRays[1];
        gatherSlices(report.slices, result.slices);
        return result;
    }

    void checkSame(const std::string& text, const char* what) override {
        uint64_t size = text.size();
        MPI_Bcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
        std::string expected = text;
        expected.resize(size);
        MPI_Bcast(expected.data(), static_cast<int>(size), MPI_CHAR, 0, MPI_COMM_WORLD);
        if (expected != text)
            throw Error("rank {}: found another {} than rank 0: {} instead of {}", rank_, what, text,
                        expected);
    }

    void abort(int status) override { MPI_Abort(MPI_COMM_WORLD, status); }

  private:
    static void addPixels(void* in, void* inOut, int* count, MPI_Datatype*) {
        const auto* from = static_cast<const PixelSum*>(in);
        auto* to = static_cast<PixelSum*>(inOut);
        for (int i = 0; i < *count; ++i) to[i] += from[i];
    }
    static bool any(bool mine) {
        int in = mine, out = 0;
        MPI_Allreduce(&in, &out, 1, MPI_INT, MPI_LOR, MPI_COMM_WORLD);
        return out != 0;
    }

    void reduceFilm(const Film& film, TeamResult& result) const {
        const auto sums = film.sums();
        if (rank_ == 0) result.sums.resize(sums.size());
        MPI_Reduce(sums.data(), result.sums.data(), static_cast<int>(sums.size()), pixelType_, pixelOp_, 0,
                   MPI_COMM_WORLD);
        const uint32_t passes = film.passes();
        MPI_Reduce(&passes, &result.passes, 1, MPI_UINT32_T, MPI_SUM, 0, MPI_COMM_WORLD);
    }

    /// One rank after the other, so that rank 0 holds one message at a time besides the result.
    void gatherSlices(const std::vector<SliceState>& own, std::vector<SliceState>& all) const {
        if (rank_ == 0) {
            for (int rank = 1; rank < size_; ++rank) {
                std::vector<SliceState> slices;
                loadState(receive(rank), slices);
                std::move(slices.begin(), slices.end(), std::back_inserter(all));
            }
        } else {
            send(saveState(own));
        }
    }
    static constexpr uint64_t kMessage = uint64_t{1} << 30;  // MPI counts bytes in an int
    static void send(const std::string& bytes) {
        const uint64_t size = bytes.size();
        MPI_Send(&size, 1, MPI_UINT64_T, 0, 0, MPI_COMM_WORLD);
        for (uint64_t at = 0; at < size; at += kMessage)
            MPI_Send(bytes.data() + at, static_cast<int>(std::min(kMessage, size - at)), MPI_CHAR, 0, 0,
                     MPI_COMM_WORLD);
    }
    static std::string receive(int rank) {
        uint64_t size = 0;
        MPI_Recv(&size, 1, MPI_UINT64_T, rank, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        std::string bytes(size, '\0');
        for (uint64_t at = 0; at < size; at += kMessage)
            MPI_Recv(bytes.data() + at, static_cast<int>(std::min(kMessage, size - at)), MPI_CHAR, rank, 0,
                     MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        return bytes;
    }

    int rank_ = 0, size_ = 1;
    uint32_t* counter_ = nullptr;
    MPI_Win window_ = MPI_WIN_NULL;
    MPI_Datatype pixelType_ = MPI_DATATYPE_NULL;
    MPI_Op pixelOp_ = MPI_OP_NULL;
};

#endif

}  // namespace

std::unique_ptr<Team> makeTeam() {
    const int processes = launchedProcesses();
    if (processes <= 1) return nullptr;
#ifdef METROLUX_MPI
    return std::make_unique<MpiTeam>();
#else
    throw Error(
        "started as one of {} processes of MPI, but this program was built without MPI: install "
        "libopenmpi-dev "
        "and build again, or divide the render with --only-slices and `metrolux merge`",
        processes);
#endif
}

}  // namespace metrolux::core
