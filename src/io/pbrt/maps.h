#pragma once
#include "io/pbrt/parameters.h"

#include <map>

namespace metrolux::core::pbrt {

/// The map in force: that of what comes next into the world, before WorldBegin of the world into the camera.
struct CurrentMap {
    Transform map;
    bool moves = true;  ///< false while ActiveTransform EndTime lets directives pass
};

/// The directives that change it: Translate, LookAt, CoordSysTransform ...
class Maps {
  public:
    /// Carries one out; false if the word is none of them.
    bool read(const Token& word, Lexer& lexer, Reading& reading, CurrentMap& current);
    void name(const std::string& system, const Transform& map) { systems_[system] = map; }
    static std::vector<std::string> directives();

  private:
    std::map<std::string, Transform> systems_;
};

}  // namespace metrolux::core::pbrt
