#include "study/machine.h"

#include "base/memory_budget.h"
#include "geometry/intersector.h"
#include "render/build_id.h"
#include "study/build_description.h"

#include <fmt/chrono.h>
#include <tbb/version.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <sys/utsname.h>
#include <thread>

namespace metrolux::core::study {
namespace {

std::string processorName() {
    std::ifstream file("/proc/cpuinfo");
    std::string line;
    while (std::getline(file, line)) {
        const size_t colon = line.find(": ");
        if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
    }
    return "unknown";
}

std::string systemName() {
    utsname name{};
    if (::uname(&name) != 0) return "unknown";
    return fmt::format("{} {} {}", name.sysname, name.release, name.machine);
}

/// Processes that want to run, mean over the last minute; negative: not known.
double loadAverage() {
    double load = -1;
    return ::getloadavg(&load, 1) == 1 ? load : -1;
}

}  // namespace

nlohmann::json describeMachine(int threads) {
    return {
        {"processor", processorName()},
        {"cores", std::thread::hardware_concurrency()},
        {"threads", threads},
        {"memory_bytes", physicalMemoryBytes()},
        {"system", systemName()},
        {"compiler", kCompiler},
        {"tbb", TBB_runtime_version()},
        {"load", loadAverage()},
        {"flags", kBuildFlags},
        {"revision", kBuildRevision},
        {"embree", Intersector::libraryVersion()},
    };
}

std::string timestamp() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

}  // namespace metrolux::core::study
