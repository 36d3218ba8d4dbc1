#pragma once
/// Progress for programs: a JSON object a line (docs/reference/command.md, "Progress for programs").

#include <metrolux/session.h>

#include <nlohmann/json_fwd.hpp>

#include <cstdio>
#include <string>

namespace metrolux::core::app {

class JsonProgress {
  public:
    explicit JsonProgress(std::FILE* to = stdout) : to_(to) {}

    void begin(const std::string& scene, const metrolux::Crop& window, const std::string& integrator,
               int threads) const;
    /// At most every tenth of a second.
    void pass(const metrolux::Progress& progress);
    /// Where a page shows the rendering.
    void page(const std::string& url) const;
    void log(const char* level, const std::string& text) const;
    void end(const metrolux::Outcome& outcome, const std::vector<std::string>& images, int status) const;
    /// In place of end(), for a rendering that cannot be.
    void error(const std::string& text, int status) const;

  private:
    /// Whoever reads may have gone away; that is no reason to end a rendering.
    void put(const nlohmann::json& object) const;
    std::FILE* to_;
    double next_ = 0;
};

}  // namespace metrolux::core::app
