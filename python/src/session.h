#pragma once
/// Sessions for Python: the same as metrolux::Session, and who may use it when.

#include "unlocked.h"

#include <metrolux/session.h>

#include <atomic>
#include <optional>
#include <pybind11/pybind11.h>
#include <thread>

namespace metrolux::python {

namespace py = pybind11;

/// When to stop, as Python says it: nothing is no limit.
struct LimitArguments {
    std::optional<double> time;
    std::optional<std::uint32_t> passes;
    std::optional<double> error;
    Limits limits() const { return {time.value_or(0), passes.value_or(0), error.value_or(0)}; }
};

/// Files that a run writes, as Python says them.
struct FileArguments {
    py::object output;  ///< a name, several, or None
    bool overwrite;
    double exposure;
    std::string curve;
    double saveEvery;
    std::optional<std::filesystem::path> checkpoint;
    double checkpointEvery;
    Files files() const;
};

/// A keyword of an integrator. Throws Error for what no parameter can be.
Parameters parametersFrom(const py::kwargs& keywords);

/// Several threads of Python may hold one. While it renders, without the interpreter's lock, only its hooks
/// and requestStop() may use it; others get an Error.
class PythonSession {
  public:
    PythonSession(Scene scene, SessionOptions options, Limits limits);

    void step();
    /// Throws what the progress function or a signal raised, after the pass in progress.
    void run(const Limits& limits, const py::object& progress, const Files& files);
    /// Renders a pass, unless a limit of the constructor is reached or a stop was requested. Whether it did.
    bool next();
    void requestStop() noexcept;
    /// Reads or saves: `action` gets the session.
    template <class Action>
    auto use(const Action& action) {
        const Use guard(*this, false);
        const Unlocked unlocked;
        return action(session_);
    }
    /// The session, to be taken apart.
    Session&& release() { return std::move(session_); }
    const Limits& limits() const { return limits_; }

  private:
    /// Checked and set under the interpreter's lock.
    struct Use {
        Use(PythonSession& session, bool renders);
        ~Use();
        Use(const Use&) = delete;
        Use& operator=(const Use&) = delete;
        PythonSession& session;
        bool isOutermost, renders;
    };

    Session session_;
    Limits limits_;
    std::atomic<bool> stop_{false};
    bool busy_ = false;
    std::thread::id user_;
};

/// What `interrupt` becomes when there is an image: metrolux.Interrupted for a KeyboardInterrupt; all others
/// get it as an attribute.
[[noreturn]] void rethrowWithImage(py::error_already_set& problem, const py::object& image);

/// Requests all renderings in progress to stop.
void stopSessions() noexcept;

void defineSession(py::module_& module);

}  // namespace metrolux::python
