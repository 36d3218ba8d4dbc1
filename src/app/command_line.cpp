#include "app/command_line.h"

#include "app/commands.h"
#include "base/error.h"
#include "base/printable.h"
#include "base/suggest.h"

#include <metrolux/version.h>

#include <fmt/format.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <malloc.h>
#include <new>
#include <sstream>

namespace metrolux::core::app {
namespace {

constexpr const char* kDescription =
    "Metrolux renders Mitsuba scenes with MCMC VCM: caustics, light through doors ajar, and both at once.";

constexpr const char* kGeneralExamples = R"(Examples:
  metrolux render scene.xml -o image.exr -o image.png --time 5m
  metrolux view scene.xml
  metrolux resume image.checkpoint
  metrolux merge part0 part1 part2 -o image.exr
  metrolux compare image.exr reference.exr --heatmap errors.png
  metrolux study scene.xml --integrators path,vcm,mcmc_vcm --time 60s --ref reference.exr
  metrolux bench scene.xml -i mcmc_vcm --json speed.json
  metrolux info scene.xml

`metrolux COMMAND --help` explains the options of a command.

Exit status: 0 done; 1 internal error; 2 options, scene or output cannot be used; 3 interrupted, the image so far
was written; 4 rendered, but an output file or the last checkpoint could not be written.)";

struct Command {
    CLI::App* app;
    Run run;
};

/// Text after an error of the options: what was probably meant, and where help is.
std::string hintFor(const CLI::ParseError& error, const CLI::App& root, const CLI::App* command) {
    std::vector<std::string> candidates;
    if (command == nullptr)
        for (const CLI::App* sub : root.get_subcommands([](const CLI::App*) { return true; }))
            candidates.push_back(sub->get_name());
    for (const CLI::Option* option : (command != nullptr ? *command : root).get_options())
        for (const std::string& name : option->get_lnames()) candidates.push_back("--" + name);
    std::string hint;
    if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
        // The message ends with the words that no option or command took.
        const std::string message = error.what();
        std::istringstream words(message.substr(message.rfind(": ") + 1));
        for (std::string word; hint.empty() && words >> word;) {
            const std::string nearest = nearestName(word.substr(0, word.find('=')), candidates);
            if (!nearest.empty()) hint = fmt::format("Did you mean {}? ", nearest);
        }
    }
    return fmt::format("{}See metrolux {}--help", hint, command != nullptr ? command->get_name() + " " : "");
}

int runCommandLine(int argc, char** argv) {
    CLI::App root(kDescription, "metrolux");
    root.footer(kGeneralExamples);
    root.set_version_flag("--version", std::string("metrolux ") + metrolux::version(),
                          "Show the version and exit");
    root.require_subcommand(0, 1);
    std::vector<Command> commands;
    for (auto* add : {&addRenderCommand, &addViewCommand, &addResumeCommand, &addMergeCommand,
                      &addCompareCommand, &addStudyCommand, &addBenchCommand, &addInfoCommand,
                      &addConvertCommand, &addIntegratorsCommand, &addCompletionsCommand}) {
        Run run = add(root);
        commands.push_back(
            {root.get_subcommands([](const CLI::App*) { return true; }).back(), std::move(run)});
    }
    const auto chosen = [&]() -> const Command* {
        for (const Command& command : commands)
            if (command.app->parsed()) return &command;
        return nullptr;
    };
    try {
        root.parse(argc, argv);
    } catch (const CLI::Success& request) {
        return root.exit(request);
    } catch (const CLI::ParseError& error) {
        fmt::print(stderr, "metrolux: {}\n", printable(error.what()));
        const Command* command = chosen();
        fmt::print(stderr, "{}\n", hintFor(error, root, command != nullptr ? command->app : nullptr));
        return kUserError;
    }
    const Command* command = chosen();
    if (command == nullptr) {
        fmt::print(stderr, "{}", root.help());
        return kUserError;
    }
    return command->run();
}

/// %*: the text of a message, printable. It may come from a file.
class PrintableText final : public spdlog::custom_flag_formatter {
  public:
    void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& to) override {
        const std::string text = printable({message.payload.data(), message.payload.size()});
        to.append(text.data(), text.data() + text.size());
    }
    std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
        return std::make_unique<PrintableText>();
    }
};

void setUpLog() {
    spdlog::set_default_logger(spdlog::stderr_color_mt("metrolux"));
    auto formatter = std::make_unique<spdlog::pattern_formatter>();
    formatter->add_flag<PrintableText>('*').set_pattern("%^[%l]%$ %*");
    spdlog::set_formatter(std::move(formatter));
}

/// Each pass stores as much as the one before: memory that goes back to the system in between is cleared and
/// mapped page by page again, 2 to 3 % of the time of a pass.
void keepFreedMemory() {
    ::mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the largest that glibc takes
    ::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

constexpr const char* kOutOfMemory = "metrolux: out of memory; try a lower --resolution or --memory\n";

std::atomic<bool> memoryRanOut{false};

/// Where an exception has nowhere to go (a thread of a library, a function that promises not to throw):
/// memory that is missing is told as elsewhere, everything else is a bug. Which exception it is may not be
/// known here.
[[noreturn]] void endWithoutException() {
    if (memoryRanOut) {
        std::fputs(kOutOfMemory, stderr);
        std::_Exit(kUserError);
    }
    try {
        if (const std::exception_ptr problem = std::current_exception()) std::rethrow_exception(problem);
    } catch (const std::exception& problem) {
        std::fprintf(stderr, "metrolux: internal error: %s\n", problem.what());
    } catch (...) {
    }
    std::abort();
}

void watchMemory() {
    std::set_new_handler([] {
        memoryRanOut = true;
        throw std::bad_alloc();
    });
    std::set_terminate(endWithoutException);
}

}  // namespace
}  // namespace metrolux::core::app

namespace {

/// The exit status.
int runAndReport(int argc, char** argv) {
    using namespace metrolux::core::app;
    try {
        setUpLog();
        return runCommandLine(argc, argv);
    } catch (const metrolux::core::Error& error) {
        fmt::print(stderr, "metrolux: {}\n", metrolux::core::printableLines(error.what()));
        return kUserError;
    } catch (const std::bad_alloc&) {
        std::fputs(kOutOfMemory, stderr);
        return kUserError;
    } catch (const std::exception& error) {
        fmt::print(stderr, "metrolux: internal error: {}\n", metrolux::core::printableLines(error.what()));
        return kInternalError;
    }
}

}  // namespace

int metroluxCommandLine(int argc, char** argv) {
    using namespace metrolux::core::app;
    keepFreedMemory();
    watchMemory();
    const int status = runAndReport(argc, argv);
    if (!memoryRanOut) return status;
    // Libraries that were left in the middle of something would be taken apart at the end, and complain.
    std::fflush(nullptr);
    std::_Exit(status);
}
