#pragma once
/// The $names of a scene: <default>s and the -D definitions that override them.

#include <map>
#include <string>
#include <vector>

namespace metrolux::core::mitsuba {

class Parameters {
  public:
    explicit Parameters(const std::map<std::string, std::string>& defines);

    /// <default name value>: the first definition of a name holds, and -D overrides it.
    void addDefault(const std::string& name, const std::string& value);
    /// Replaces $name and ${name}; a backslash before the dollar sign keeps it. Like Mitsuba, $nameSuffix
    /// takes the longest known name. Throws Error for an unknown name (with the nearest known one) and for
    /// runaway lengths.
    std::string substitute(const std::string& text);
    /// Throws Error for a -D name that no <default> declares and nothing uses.
    void checkDefinesUsed(const std::string& file) const;

    /// Where a warning goes for an attribute that its element does not know; null: that is an error.
    std::vector<std::string>* forgiven = nullptr;

  private:
    struct Entry {
        std::string value;
        bool fromCommandLine = false;
        bool known = false;  ///< declared by the scene or used in it
    };
    std::vector<std::string> names() const;
    std::string definedText() const;  ///< for messages: what there is
    std::map<std::string, Entry> entries_;
};

}  // namespace metrolux::core::mitsuba
