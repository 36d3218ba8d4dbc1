#include "session.h"
#include "values.h"

#include <metrolux/error.h>

#include <exception>
#include <set>

namespace metrolux::python {
namespace {

/// Watches a run between its passes, in the thread that renders.
class Watch {
  public:
    explicit Watch(py::object progress) : progress_(std::move(progress)) {}

    Hooks hooks() {
        return {[this](const Progress& p) { passed(p); }, [this] { return stops(); }};
    }
    /// Throws what Python raised meanwhile, or by a signal that came at the end.
    void finish() {
        if (!problem_) noteSignals();
        if (problem_) std::rethrow_exception(problem_);
    }

  private:
    void passed(const Progress& p) {
        if (progress_.is_none()) return;
        const py::gil_scoped_acquire acquire;
        try {
            stop_ = stop_ || progress_(p).is(py::bool_(false));
        } catch (py::error_already_set&) {
            problem_ = std::current_exception();
        }
    }
    bool stops() {
        const py::gil_scoped_acquire acquire;
        if (!problem_) noteSignals();
        return stop_ || problem_;
    }
    /// Ctrl-C, and what other signals have handlers in Python; nothing but in the main thread.
    void noteSignals() {
        if (PyErr_CheckSignals() != 0) problem_ = std::make_exception_ptr(py::error_already_set());
    }

    py::object progress_;
    std::exception_ptr problem_;
    bool stop_ = false;
};

/// Sessions that render, under the interpreter's lock.
std::set<PythonSession*> rendering;

/// Throws Error for the files that were not written.
void checkWritten(const Outcome& outcome) {
    std::string lost;
    for (const std::string& failure : outcome.failures) lost += (lost.empty() ? "" : "\n") + failure;
    for (const std::filesystem::path& file : outcome.rescued)
        lost += "\nthe image is in " + file.string() + " instead";
    if (!outcome.checkpointFailure.empty())
        lost += (lost.empty() ? "" : "\n") +
                ("the last checkpoint was not written: " + outcome.checkpointFailure);
    if (!lost.empty()) throw Error(lost);
}

}  // namespace

Files FileArguments::files() const {
    Files files;
    if (py::isinstance<py::list>(output) || py::isinstance<py::tuple>(output))
        for (const py::handle file : output)
            files.images.emplace_back(py::module_::import("os").attr("fspath")(file).cast<std::string>());
    else if (!output.is_none())
        files.images.emplace_back(py::module_::import("os").attr("fspath")(output).cast<std::string>());
    files.display = {exposure, curve};
    files.overwrite = overwrite;
    files.saveEvery = saveEvery;
    files.checkpoint = checkpoint.value_or(std::filesystem::path());
    files.checkpointEvery = checkpointEvery;
    return files;
}

Parameters parametersFrom(const py::kwargs& keywords) {
    Parameters parameters;
    for (const auto& [key, value] : keywords) {
        const auto name = key.cast<std::string>();
        if (py::isinstance<py::str>(value)) {
            parameters[name] = value.cast<std::string>();
        } else if (const std::optional<Number> number = numberFrom(value)) {
            std::visit([&](auto n) { parameters[name] = n; }, *number);
        } else {
            throw Error(name + ": found " + Py_TYPE(value.ptr())->tp_name +
                        ", expected a number, a bool or a string");
        }
    }
    return parameters;
}

PythonSession::Use::Use(PythonSession& s, bool isRendering)
    : session(s), isOutermost(!s.busy_), renders(isRendering) {
    if (s.busy_ && (renders || s.user_ != std::this_thread::get_id()))
        throw Error(
            "the session is rendering: until the end only stop() may be called, and by the progress "
            "function what does not render");
    if (!isOutermost) return;
    s.busy_ = true;
    s.user_ = std::this_thread::get_id();
    if (renders) rendering.insert(&s);
}

PythonSession::Use::~Use() {
    if (!isOutermost) return;
    session.busy_ = false;
    rendering.erase(&session);
}

PythonSession::PythonSession(Scene scene, SessionOptions options, Limits limits)
    : session_([&] {
          const Unlocked unlocked;
          return Session(std::move(scene), std::move(options));
      }()),
      limits_(limits) {}

void PythonSession::step() {
    const Use guard(*this, true);
    const Unlocked unlocked;
    session_.step();
}

void PythonSession::run(const Limits& limits, const py::object& progress, const Files& files) {
    const Use guard(*this, true);
    Watch watch(progress);
    const Outcome outcome = [&] {
        const Unlocked unlocked;
        return session_.render(limits, watch.hooks(), files);
    }();
    stop_ = false;
    watch.finish();
    checkWritten(outcome);
}

bool PythonSession::next() {
    const Use guard(*this, true);
    Limits any;
    any.passes = 1;
    if (stop_.exchange(false)) {  // the session may have had the request or not: it has not afterwards
        session_.render(any, {{}, [] { return true; }});
        return false;
    }
    const std::uint32_t before = session_.progress().passes;
    Watch watch{py::none()};
    Hooks hooks = watch.hooks();
    hooks.stop = [&, stops = hooks.stop] { return stops() || session_.progress().passes > before; };
    {
        const Unlocked unlocked;
        if (limits_.any())
            session_.render(limits_, hooks);
        else
            session_.step();
    }
    watch.finish();
    return session_.progress().passes > before;
}

void stopSessions() noexcept {
    for (PythonSession* session : rendering) session->requestStop();
}

void PythonSession::requestStop() noexcept {
    stop_ = true;
    session_.requestStop();
}

}  // namespace metrolux::python
