#include "app/progress_json.h"

#include <metrolux/version.h>

#include <nlohmann/json.hpp>

#include <cmath>

namespace metrolux::core::app {
namespace {

const char* nameOf(metrolux::StopReason reason) {
    switch (reason) {
        case metrolux::StopReason::Time:
            return "time";
        case metrolux::StopReason::Passes:
            return "passes";
        case metrolux::StopReason::Error:
            return "error";
        case metrolux::StopReason::Full:
            return "full";
        case metrolux::StopReason::Interrupted:
            break;
    }
    return "interrupted";
}

nlohmann::json namesOf(const std::vector<std::filesystem::path>& files) {
    nlohmann::json names = nlohmann::json::array();
    for (const std::filesystem::path& file : files) names.push_back(file.string());
    return names;
}

}  // namespace

void JsonProgress::put(const nlohmann::json& object) const {
    const std::string line = object.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
    std::fputs(line.c_str(), to_);
    std::fflush(to_);
}

void JsonProgress::begin(const std::string& scene, const metrolux::Crop& window,
                         const std::string& integrator, int threads) const {
    put({{"event", "begin"},
         {"version", metrolux::version()},
         {"scene", scene},
         {"width", window.width},
         {"height", window.height},
         {"integrator", integrator},
         {"threads", threads}});
}

void JsonProgress::pass(const metrolux::Progress& p) {
    constexpr double kInterval = 0.1;
    if (p.seconds < next_) return;
    next_ = p.seconds + kInterval;
    nlohmann::json line{{"event", "pass"},
                        {"passes", p.passes},
                        {"seconds", p.seconds},
                        {"seconds_remaining", nullptr},
                        {"relative_error", nullptr},
                        {"rays_per_second", p.raysPerSecond},
                        {"note", p.note}};
    if (p.secondsRemaining >= 0) line["seconds_remaining"] = p.secondsRemaining;
    if (std::isfinite(p.relativeError)) line["relative_error"] = p.relativeError;
    put(line);
}

void JsonProgress::page(const std::string& url) const { put({{"event", "page"}, {"url", url}}); }

void JsonProgress::log(const char* level, const std::string& text) const {
    put({{"event", "log"}, {"level", level}, {"text", text}});
}

void JsonProgress::end(const metrolux::Outcome& outcome, const std::vector<std::string>& images,
                       int status) const {
    put({{"event", "end"},
         {"status", status},
         {"reason", nameOf(outcome.reason)},
         {"passes", outcome.passes},
         {"images", outcome.passes > 0 ? images : std::vector<std::string>()},
         {"rescued", namesOf(outcome.rescued)},
         {"failures", outcome.failures}});
}

void JsonProgress::error(const std::string& text, int status) const {
    put({{"event", "error"}, {"status", status}, {"text", text}});
}

}  // namespace metrolux::core::app
