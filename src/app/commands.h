#pragma once
#include <CLI/CLI.hpp>

#include <functional>

namespace metrolux::core::app {

/// Exit statuses; docs and --help list them.
enum ExitStatus : int {
    kDone = 0,
    kInternalError = 1,  ///< a bug, or the system failed (no memory ...)
    kUserError = 2,      ///< options, scene or output cannot be used; nothing was rendered
    kInterrupted = 3,    ///< SIGINT or SIGTERM; the image so far was written
    kOutputLost = 4,  ///< rendered, but a named output or the last checkpoint could not be written (a rescue
                      ///< copy is tried)
};

/// A subcommand is set up with its options and says how to run it.
using Run = std::function<int()>;
Run addRenderCommand(CLI::App& parent);
Run addViewCommand(CLI::App& parent);
Run addResumeCommand(CLI::App& parent);
Run addMergeCommand(CLI::App& parent);
Run addCompareCommand(CLI::App& parent);
Run addStudyCommand(CLI::App& parent);
Run addBenchCommand(CLI::App& parent);
Run addInfoCommand(CLI::App& parent);
Run addConvertCommand(CLI::App& parent);
Run addIntegratorsCommand(CLI::App& parent);
Run addCompletionsCommand(CLI::App& parent);

}  // namespace metrolux::core::app
