#pragma once
#include <optional>
#include <pybind11/pybind11.h>

namespace metrolux::python {

namespace py = pybind11;

/// Work without the interpreter's lock. Its end waits for such work: a thread that asks for the lock later
/// would be killed by it in the middle of C++. Once it has begun to wait, what would begin raises SystemExit,
/// which ends a thread without a word.
class Unlocked {
  public:
    Unlocked();
    ~Unlocked();
    Unlocked(const Unlocked&) = delete;
    Unlocked& operator=(const Unlocked&) = delete;

  private:
    std::optional<py::gil_scoped_release> release_;
};

/// Called when the interpreter ends: refuses new work, and returns when there is none in progress.
void finishUnlockedWork();

}  // namespace metrolux::python
