/// The only code that knows MPI. It is a library that render/team.cpp loads, so that other processes need
/// not.

#include "render/communicator.h"

#include <algorithm>
#include <mpi.h>
#include <stdexcept>

namespace metrolux::core {
namespace {

constexpr size_t kMessage = size_t{1} << 30;  // MPI counts bytes in an int

class MpiCommunicator final : public Communicator {
  public:
    MpiCommunicator() {
        int provided = 0;
        MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
        if (provided < MPI_THREAD_SERIALIZED)
            throw std::runtime_error("MPI: found no support for threads, expected MPI_THREAD_SERIALIZED");
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &size_);
        MPI_Op_create(&addRecords, 1, &recordOp_);
        MPI_Win_allocate(rank_ == 0 ? sizeof(uint32_t) : 0, sizeof(uint32_t), MPI_INFO_NULL, MPI_COMM_WORLD,
                         &counter_, &window_);
        if (rank_ == 0) *counter_ = 0;
        MPI_Barrier(MPI_COMM_WORLD);
    }
    ~MpiCommunicator() override {
        MPI_Win_free(&window_);
        MPI_Op_free(&recordOp_);
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
    bool any(bool mine) override {
        int in = mine, out = 0;
        MPI_Allreduce(&in, &out, 1, MPI_INT, MPI_LOR, MPI_COMM_WORLD);
        return out != 0;
    }
    void sum(const uint32_t* in, uint32_t* out, int count) override {
        MPI_Reduce(in, out, count, MPI_UINT32_T, MPI_SUM, 0, MPI_COMM_WORLD);
    }
    void sum(const uint64_t* in, uint64_t* out, int count) override {
        MPI_Reduce(in, out, count, MPI_UINT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
    }
    void sum(const double* in, double* out, int count) override {
        MPI_Reduce(in, out, count, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
    }
    void sumRecords(const void* in, void* out, int count, int bytes, AddRecords add) override {
        add_ = add;
        MPI_Datatype record = MPI_DATATYPE_NULL;
        MPI_Type_contiguous(bytes, MPI_BYTE, &record);
        MPI_Type_commit(&record);
        MPI_Reduce(in, out, count, record, recordOp_, 0, MPI_COMM_WORLD);
        MPI_Type_free(&record);
    }
    void broadcast(void* bytes, size_t count) override {
        inPieces(count, [&](size_t at, int size) {
            MPI_Bcast(static_cast<char*>(bytes) + at, size, MPI_BYTE, 0, MPI_COMM_WORLD);
        });
    }
    void send(const void* bytes, size_t count) override {
        inPieces(count, [&](size_t at, int size) {
            MPI_Send(static_cast<const char*>(bytes) + at, size, MPI_BYTE, 0, 0, MPI_COMM_WORLD);
        });
    }
    void receive(int rank, void* bytes, size_t count) override {
        inPieces(count, [&](size_t at, int size) {
            MPI_Recv(static_cast<char*>(bytes) + at, size, MPI_BYTE, rank, 0, MPI_COMM_WORLD,
                     MPI_STATUS_IGNORE);
        });
    }
    void abort(int status) override { MPI_Abort(MPI_COMM_WORLD, status); }

  private:
    static void addRecords(void* in, void* inOut, int* count, MPI_Datatype*) { add_(in, inOut, *count); }
    template <class Action>
    static void inPieces(size_t count, const Action& action) {
        for (size_t at = 0; at < count; at += kMessage)
            action(at, static_cast<int>(std::min(kMessage, count - at)));
    }

    static inline AddRecords add_ = nullptr;  // MPI gives its operations no other place
    int rank_ = 0, size_ = 1;
    uint32_t* counter_ = nullptr;
    MPI_Win window_ = MPI_WIN_NULL;
    MPI_Op recordOp_ = MPI_OP_NULL;
};

}  // namespace
}  // namespace metrolux::core

extern "C" __attribute__((visibility("default"))) metrolux::core::Communicator* metroluxMakeCommunicator() {
    return new metrolux::core::MpiCommunicator;
}
