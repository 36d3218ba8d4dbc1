#pragma once
/// What the parser reads from one XML node: its attributes with $names replaced, its place, its errors.

#include "io/mitsuba/parameters.h"
#include "io/mitsuba/source.h"

#include <initializer_list>
#include <optional>

namespace metrolux::core::mitsuba {

/// Error text that begins with the node's place: `scene.xml:12: <rgb name="reflectance">: ...`.
Error nodeError(const Source& source, pugi::xml_node node, const std::string& message);

class Attributes {
  public:
    /// Throws Error if a required attribute is missing or one stands there that is neither required nor
    /// optional, unless that is forgiven (Parameters).
    Attributes(const Source& source, pugi::xml_node node, Parameters& parameters,
               std::initializer_list<const char*> required, std::initializer_list<const char*> optional = {});

    const std::string* find(const char* name) const;
    bool has(const char* name) const { return find(name) != nullptr; }
    /// Value of a required attribute.
    const std::string& operator[](const char* name) const { return *find(name); }
    std::string get(const char* name, const std::string& fallback = {}) const {
        const std::string* value = find(name);
        return value ? *value : fallback;
    }

  private:
    std::vector<std::pair<std::string, std::string>> values_;
};

/// The product of the <translate>, <rotate>, <scale>, <lookat> and <matrix> of a <transform>: each is applied
/// after those before it. `steps`, if given, receives them as text.
Transform parseTransform(const Source& source, pugi::xml_node node, Parameters& parameters, bool legacy,
                         std::string* steps = nullptr);

}  // namespace metrolux::core::mitsuba
