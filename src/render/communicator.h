#pragma once
#include <cstddef>
#include <cstdint>

namespace metrolux::core {

/// Messages between the processes that a launcher has started together. MPI is behind it, in a library of its
/// own (src/mpi) that is loaded only there, for loading MPI takes longer than a small rendering. All
/// processes call each function together, but for takeNumber, send, receive and abort.
class Communicator {
  public:
    virtual ~Communicator() = default;
    virtual int rank() const = 0;
    virtual int size() const = 0;
    /// 0, 1, 2 ...: each number once, whoever asks.
    virtual uint32_t takeNumber() = 0;
    /// Whether it is true on any process; all get the answer.
    virtual bool any(bool mine) = 0;
    /// Sums to rank 0, which alone has an `out`.
    virtual void sum(const uint32_t* in, uint32_t* out, int count) = 0;
    virtual void sum(const uint64_t* in, uint64_t* out, int count) = 0;
    virtual void sum(const double* in, double* out, int count) = 0;
    /// The same of records of `bytes` bytes each, which `add` adds to others.
    using AddRecords = void (*)(const void* from, void* to, int count);
    virtual void sumRecords(const void* in, void* out, int count, int bytes, AddRecords add) = 0;
    /// From rank 0 to all.
    virtual void broadcast(void* bytes, size_t count) = 0;
    /// To rank 0, and there from another.
    virtual void send(const void* bytes, size_t count) = 0;
    virtual void receive(int rank, void* bytes, size_t count) = 0;
    /// Ends all processes.
    virtual void abort(int status) = 0;
};

/// The one function of that library. Throws std::runtime_error.
using MakeCommunicator = Communicator* (*)();
inline constexpr const char* kMakeCommunicator = "metroluxMakeCommunicator";

}  // namespace metrolux::core
