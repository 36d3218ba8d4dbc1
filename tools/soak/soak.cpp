/// Renders random scenes with all integrators for some time, and counts what should not happen: crashes,
/// hangs, errors after a scene was read, values that are not finite in an image, memory that is lost,
/// renderings that are another one after they were saved and resumed. A child process renders; when it dies,
/// the next one goes on after the scene that ended it. Meant for a build with sanitizers (`make soak`).

#include "base/clock.h"
#include "base/error.h"
#include "base/rng.h"
#include "base/state_archive.h"
#include "integrators/registry.h"
#include "io/scene_loader.h"
#include "random_scene.h"
#include "render/session.h"
#include "render/threads.h"
#include "support/parameter_values.h"
#include "support/temporary_folder.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <poll.h>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace metrolux::core::soak {
namespace {

namespace fs = std::filesystem;

struct Settings {
    double seconds = 60, limit = 300;
    uint64_t seed = 1, count = ~uint64_t{0};
    int passes = 4, threads = 2;
    std::vector<std::string> integrators;
    fs::path folder, report;
    int pipe = -1;  ///< of a child: where it reports
};

uint64_t residentBytes() {
    uint64_t total = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> total >> resident;
    return resident * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

// The child: renders, and writes lines of JSON to a pipe.

class Reporter {
  public:
    explicit Reporter(int pipe) : pipe_(pipe) {}
    void say(const nlohmann::json& message) const {
        const std::string line = message.dump() + "\n";
        if (::write(pipe_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) ::_exit(3);
    }

  private:
    int pipe_;
};

/// What a user may choose, by the seed.
struct Choice {
    std::string integrator;
    CommonOptions options;
    ParameterValues parameters;
};

Choice randomChoice(uint64_t seed, const Scene& scene, const std::string& integrator) {
    CounterRng rng(hashKey(seed, 0x0b7));
    Choice choice{integrator, {}, {}};
    choice.options.seed = seed;
    choice.options.limits = scene.parts().limits;
    choice.options.memoryBytes = rng.next1D() < 0.2f ? 20000 : 0;  // several iterations in a pass
    for (const ParameterInfo& info : findIntegrator(integrator).parameters) {
        if (rng.next1D() >= 0.2f) continue;
        const std::vector<ParameterValue> values = test::otherValues(info);
        choice.parameters[info.name] = values[static_cast<size_t>(rng.next1D() * float(values.size()))];
    }
    for (const char* radius : {"radius", "medium_radius"})
        if (choice.parameters.contains(radius))
            choice.parameters[radius] = double(scene.bounds().radius) * (rng.next1D() < 0.5f ? 1e-7 : 1);
    // A measured split is for all replicas.
    const auto split = choice.parameters.find("split");
    if (split != choice.parameters.end() && toText(split->second) == "auto")
        choice.parameters.erase("replicas");
    return choice;
}

/// A film and what renders it.
class Rendering {
  public:
    Rendering(const Scene& scene, const Choice& choice)
        : film_(makeFilm(scene)),
          integrator_(makeIntegrator(choice.integrator, scene, choice.options, choice.parameters)) {}

    void render(int passes) {
        for (int i = 0; i < passes; ++i) integrator_->renderPass(film_, film_.passes());
    }
    const Film& film() const { return film_; }
    TechniqueCounts nonFinite() const { return integrator_->nonFinite(); }
    std::string state() const {
        StateWriter writer;
        film_.saveState(writer);
        integrator_->saveState(writer);
        return writer.take();
    }
    void load(const std::string& state) {
        StateReader reader(state);
        film_.loadState(reader);
        integrator_->loadState(reader);
        reader.checkEnd();
    }

  private:
    Film film_;
    std::unique_ptr<Integrator> integrator_;
};

/// The pass after which the scene's renderings are saved and resumed; 0: they are not.
int passBeforeResume(uint64_t seed, int passes) {
    CounterRng rng(hashKey(seed, 0xc4e));
    if (passes < 2 || rng.next1D() >= 0.3f) return 0;
    return 1 + static_cast<int>(rng.next1D() * static_cast<float>(passes - 1));
}

void render(const Settings& settings, const Scene& scene, const std::string& integrator, uint64_t seed,
            const Reporter& reporter) {
    reporter.say({{"begin", integrator}});
    const Choice choice = randomChoice(seed, scene, integrator);
    const int stop = passBeforeResume(seed, settings.passes);
    Rendering whole(scene, choice);
    whole.render(stop);
    const std::string saved = stop > 0 ? whole.state() : "";
    whole.render(settings.passes - stop);
    const std::vector<float> image = whole.film().image();
    const auto bad = std::count_if(image.begin(), image.end(), [](float v) { return !std::isfinite(v); });
    nlohmann::json result{
        {"rendered", integrator}, {"bad_values", bad}, {"rejected", toJson(whole.nonFinite())}};
    if (stop > 0) {
        Rendering resumed(scene, choice);
        resumed.load(saved);
        resumed.render(settings.passes - stop);
        // The states hold the films' exact sums: more than the image.
        result["resumed_is_same"] = resumed.state() == whole.state();
    }
    reporter.say(result);
}

fs::path writeScene(const fs::path& folder, uint64_t seed) {
    const RandomScene scene = makeRandomScene(seed);
    for (const auto& [name, content] : scene.files) std::ofstream(folder / name, std::ios::binary) << content;
    const fs::path file = folder / "scene.xml";
    std::ofstream(file) << scene.xml;
    return file;
}

void renderScene(const Settings& settings, uint64_t seed, const Reporter& reporter) {
    LoadOptions options;
    options.memoryBytes = uint64_t{1} << 30;
    std::optional<Scene> scene;
    try {
        scene.emplace(loadScene(writeScene(settings.folder, seed), options));
    } catch (const Error& error) {
        return reporter.say({{"refused", error.what()}});
    }
    for (const std::string& integrator : settings.integrators) {
        try {
            render(settings, *scene, integrator, seed, reporter);
        } catch (const Error& error) {
            reporter.say({{"failed", error.what()}});
        }
    }
}

int runChild(const Settings& settings) {
    const Reporter reporter(settings.pipe);
    const uint64_t first = settings.seed;
    const double end = steadySeconds() + settings.seconds;
    ThreadLimit limit(settings.threads);
    limit.execute([&] {
        for (uint64_t seed = first; steadySeconds() < end && seed - settings.seed < settings.count; ++seed) {
            reporter.say({{"scene", seed}});
            renderScene(settings, seed, reporter);
            reporter.say({{"done", seed}, {"resident_bytes", residentBytes()}});
        }
    });
    reporter.say({{"finished", true}});
    return 0;
}

// The parent: counts what the child says, and notices when it stops to.

/// Tells a process that hangs from one that only waits for a processor: it has used `limit` seconds of
/// processor time since its last word, or has slept through as many seconds of the clock.
class HangDetector {
  public:
    HangDetector(pid_t process, double limit) : process_(process), limit_(limit) { hearWord(); }

    void hearWord() {
        wordUsed_ = used();
        beginPeriod(wordUsed_);
    }
    bool hangs() {
        const double now = used();
        if (now - wordUsed_ >= limit_) return true;
        if (steadySeconds() - periodStart_ < limit_) return false;
        const bool asleep = now - periodUsed_ < kAwake * limit_;
        beginPeriod(now);
        return asleep;
    }

  private:
    static constexpr double kAwake = 0.01;  ///< share of a processor that even a starved process gets

    double used() const {
        clockid_t clock;
        timespec time{};
        if (::clock_getcpuclockid(process_, &clock) != 0 || ::clock_gettime(clock, &time) != 0) return 0;
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }
    void beginPeriod(double usedNow) {
        periodStart_ = steadySeconds();
        periodUsed_ = usedNow;
    }

    pid_t process_;
    double limit_;
    double wordUsed_ = 0, periodStart_ = 0, periodUsed_ = 0;
};

class Supervisor {
  public:
    explicit Supervisor(const Settings& settings) : settings_(settings) {}

    /// Whether nothing went wrong.
    bool run() {
        const double start = steadySeconds(), end = start + settings_.seconds;
        next_ = settings_.seed;
        while (steadySeconds() < end && next_ - settings_.seed < settings_.count) runOne(end);
        report(steadySeconds() - start);
        return problems_.empty();
    }

  private:
    void runOne(double end) {
        int ends[2];
        if (::pipe(ends) != 0) throw Error("no pipe: {}", std::strerror(errno));
        std::fflush(nullptr);
        const pid_t child = ::fork();
        if (child < 0) throw Error("no process: {}", std::strerror(errno));
        if (child == 0) {
            ::close(ends[0]);
            becomeChild(end - steadySeconds(), ends[1]);
        }
        ::close(ends[1]);
        finished_ = false;
        const bool hung = !listen(ends[0], HangDetector(child, settings_.limit));
        ::close(ends[0]);
        if (hung) ::kill(child, SIGKILL);
        int status = 0;
        ::waitpid(child, &status, 0);
        if (hung)
            problem(
                fmt::format("no progress for {} s of processor time, or asleep as long", settings_.limit));
        else if (WIFSIGNALED(status))
            problem(fmt::format("ended by signal {}", WTERMSIG(status)));
        else if (WEXITSTATUS(status) != 0)
            problem(fmt::format("ended with status {}{}", WEXITSTATUS(status),
                                finished_ ? " after the last scene (a leak?)" : ""));
        ++next_;
    }

    /// A program of its own: a fork does not have the threads that libraries have started.
    [[noreturn]] void becomeChild(double seconds, int pipe) const {
        const uint64_t left = settings_.count - (next_ - settings_.seed);
        std::vector<std::string> words{
            "metrolux_soak",
            fmt::format("--child={}", pipe),
            fmt::format("--seed={}", next_),
            fmt::format("--count={}", left),
            fmt::format("--seconds={}", std::max(seconds, 0.0)),
            fmt::format("--passes={}", settings_.passes),
            fmt::format("--threads={}", settings_.threads),
            fmt::format("--keep={}", settings_.folder.string()),
            fmt::format("--integrators={}", fmt::join(settings_.integrators, ",")),
        };
        std::vector<char*> arguments;
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        ::execv("/proc/self/exe", arguments.data());
        ::_exit(4);
    }

    /// Until the child closes the pipe; false if it hangs.
    bool listen(int pipe, HangDetector detector) {
        std::string pending;
        for (;;) {
            pollfd wait{pipe, POLLIN, 0};
            if (::poll(&wait, 1, 1000) == 0) {
                if (detector.hangs()) return finished_;
                continue;
            }
            char buffer[4096];
            const ssize_t size = ::read(pipe, buffer, sizeof(buffer));
            if (size <= 0) return true;
            detector.hearWord();
            pending.append(buffer, static_cast<size_t>(size));
            for (size_t end; (end = pending.find('\n')) != std::string::npos; pending.erase(0, end + 1))
                hear(nlohmann::json::parse(pending.substr(0, end)));
        }
    }

    void hear(const nlohmann::json& message) {
        if (message.contains("scene")) {
            next_ = message["scene"].get<uint64_t>();
            integrator_ = "loading";
        } else if (message.contains("begin")) {
            integrator_ = message["begin"].get<std::string>();
        } else if (message.contains("rendered")) {
            ++renders_;
            if (message["bad_values"].get<int64_t>() != 0)
                problem(fmt::format("{} values not finite", message["bad_values"].dump()));
            for (const auto& [technique, count] : message["rejected"].items())
                rejected_[technique] += count.get<uint64_t>();
            if (message.contains("resumed_is_same")) {
                ++resumed_;
                if (!message["resumed_is_same"].get<bool>())
                    problem("another state after it was saved and resumed");
            }
        } else if (message.contains("refused")) {
            ++refused_;
            fmt::print("scene {} refused: {}\n", next_, message["refused"].get<std::string>());
        } else if (message.contains("failed")) {
            problem(message["failed"].get<std::string>());
        } else if (message.contains("done")) {
            ++scenes_;
            resident_.push_back(message["resident_bytes"].get<uint64_t>());
        } else {
            finished_ = true;
            integrator_ = "end";
        }
    }

    void problem(const std::string& what) {
        problems_.push_back(fmt::format("scene {}, {}: {}", next_, integrator_, what));
        fmt::print("PROBLEM: {}\n", problems_.back());
        std::fflush(stdout);
    }

    /// Largest resident set of a tenth of the scenes.
    double residentMiB(size_t tenth) const {
        const size_t begin = resident_.size() * tenth / 10, end = resident_.size() * (tenth + 1) / 10;
        uint64_t largest = 0;
        for (size_t i = begin; i < end; ++i) largest = std::max(largest, resident_[i]);
        return static_cast<double>(largest) / (1 << 20);
    }

    void report(double seconds) const {
        nlohmann::json memory = nlohmann::json::array();
        for (size_t tenth = 0; tenth < 10; ++tenth) memory.push_back(std::round(residentMiB(tenth)));
        const nlohmann::json result = {{"seconds", seconds},
                                       {"first_seed", settings_.seed},
                                       {"scenes", scenes_},
                                       {"refused", refused_},
                                       {"renders", renders_},
                                       {"resumed", resumed_},
                                       {"passes_each", settings_.passes},
                                       {"integrators", settings_.integrators},
                                       {"rejected_contributions", rejected_},
                                       {"resident_mib_by_tenths", memory},
                                       {"problems", problems_}};
        fmt::print("{}\n", result.dump(2));
        if (!settings_.report.empty()) std::ofstream(settings_.report) << result.dump(2) << "\n";
    }

    const Settings& settings_;
    uint64_t next_ = 0, scenes_ = 0, refused_ = 0, renders_ = 0, resumed_ = 0;
    bool finished_ = false;
    std::string integrator_;
    std::map<std::string, uint64_t> rejected_;
    std::vector<uint64_t> resident_;
    std::vector<std::string> problems_;
};

int run(int argc, char** argv) {
    Settings settings;
    CLI::App app(
        "Renders random scenes with all integrators and counts crashes, hangs, bad values and leaks");
    app.add_option("--seconds", settings.seconds, "Time to render for (default: 60)");
    app.add_option("--count", settings.count, "Number of scenes at most");
    app.add_option("--seed", settings.seed, "Number of the first scene (default: 1)");
    app.add_option("--passes", settings.passes, "Passes of each integrator (default: 4)");
    app.add_option("--threads", settings.threads, "Threads (default: 2)");
    app.add_option(
        "--limit", settings.limit,
        "Seconds of processor time, or asleep, without progress that count as a\nhang (default: 300)");
    app.add_option("--integrators", settings.integrators, "Names, separated by commas (default: all)")
        ->delimiter(',');
    app.add_option("--report", settings.report, "JSON file for the counts");
    app.add_option("--keep", settings.folder, "Folder for the scene in work (default: a temporary one)");
    app.add_option("--child", settings.pipe, "File descriptor to report to (set by the program itself)");
    CLI11_PARSE(app, argc, argv);
    if (settings.pipe >= 0) return runChild(settings);
    if (settings.integrators.empty())
        for (const IntegratorDescription& integrator : integratorList())
            settings.integrators.push_back(integrator.name);
    std::optional<test::TemporaryFolder> temporary;
    if (settings.folder.empty()) settings.folder = temporary.emplace().path();
    fs::create_directories(settings.folder);
    return Supervisor(settings).run() ? 0 : 1;
}

}  // namespace
}  // namespace metrolux::core::soak

int main(int argc, char** argv) {
    try {
        return metrolux::core::soak::run(argc, argv);
    } catch (const std::exception& error) {
        fmt::print(stderr, "metrolux_soak: {}\n", error.what());
        return 2;
    }
}
