#include "unlocked.h"

#include <chrono>
#include <thread>

namespace metrolux::python {
namespace {

// Under the interpreter's lock.
int inProgress = 0;
bool isEnding = false;

}  // namespace

Unlocked::Unlocked() {
    if (isEnding) {
        PyErr_SetNone(PyExc_SystemExit);
        throw py::error_already_set();
    }
    ++inProgress;
    release_.emplace();
}

Unlocked::~Unlocked() {
    release_.reset();
    --inProgress;
}

void finishUnlockedWork() {
    isEnding = true;
    while (inProgress > 0) {
        const py::gil_scoped_release release;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

}  // namespace metrolux::python
