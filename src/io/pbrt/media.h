#pragma once
#include "io/pbrt/spectra.h"

namespace metrolux::core::pbrt {

/// The media of a scene, by their names.
class Media {
  public:
    explicit Media(Reading& reading) : reading_(reading) {}

    /// MakeNamedMedium, in the space of `toWorld`.
    void define(const std::string& name, const Parameters& parameters, const Transform& toWorld,
                const ColorSpace& space);
    /// Null for the empty name, and for one that is left out. Throws Error for an unknown name.
    mitsuba::ElementPtr find(const std::string& name, const Location& where) const;

    /// Types that are read, for messages and documents.
    static std::vector<std::string> types();

  private:
    Reading& reading_;
    std::map<std::string, mitsuba::ElementPtr> media_;
};

/// What MediumInterface says: names, empty for empty space.
struct MediumInterface {
    std::string interior, exterior;
    Location where;
};

/// The sensor or light in a medium that may be null.
mitsuba::ElementPtr placedIn(const mitsuba::ElementPtr& element, const mitsuba::ElementPtr& medium);

}  // namespace metrolux::core::pbrt
