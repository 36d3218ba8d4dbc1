#pragma once
/// The parameters of a directive: "type name" [values] ...

#include "io/pbrt/lexer.h"

namespace metrolux::core::pbrt {

struct Parameter {
    std::string type, name;
    std::vector<double> numbers;
    std::vector<std::string> strings;  ///< truth values are "true" and "false"
    Location where;
    mutable bool used = false;

    Error error(const std::string& message) const {
        return Error("{}: \"{} {}\": {}", where.str(), type, name, message);
    }
};

/// What all readers of a scene share.
struct Reading {
    bool lenient = false;
    MemoryBudget& memory;
    std::vector<std::string> warnings = {};
    std::filesystem::path folder = {};  ///< of the scene: where files are looked for
    std::set<std::string> files = {};   ///< that were read

    void warn(const Error& message) { warnings.emplace_back(message.what()); }
    /// What is not supported: an error, or leniently a warning.
    void refuse(const Error& message, const std::string& instead) {
        if (!lenient) throw message;
        warnings.emplace_back(std::string(message.what()) + " (" + instead + ")");
    }
    /// The existing file that a parameter names.
    std::filesystem::path find(const std::string& name, const Location& where);
};

class Parameters {
  public:
    Parameters() = default;
    Parameters(std::string owner, Location where) : owner_(std::move(owner)), where_(std::move(where)) {}

    /// What follows in the file.
    void read(Lexer& lexer, MemoryBudget& memory);
    /// Those of `defaults` whose names are not here.
    void addDefaults(const std::vector<Parameter>& defaults);

    const Location& where() const { return where_; }
    /// "scene.pbrt:12: Shape "sphere": message".
    Error error(const std::string& message) const {
        return Error("{}: {}: {}", where_.str(), owner_, message);
    }

    /// Null if absent; marks it as used.
    const Parameter* find(const std::string& name) const;
    bool has(const std::string& name) const { return find(name) != nullptr; }

    // Throw Error for another type or count.
    double number(const std::string& name, double fallback) const;
    int64_t integer(const std::string& name, int64_t fallback) const;
    bool boolean(const std::string& name, bool fallback) const;
    std::string string(const std::string& name, const std::string& fallback) const;
    std::string requiredString(const std::string& name) const;
    Vec3d vector(const std::string& name, const Vec3d& fallback) const;
    /// Any number of groups of `size` numbers; empty if absent.
    const std::vector<double>& numbers(const std::string& name, size_t size) const;
    void ignore(std::initializer_list<const char*> names) const;

    const std::vector<Parameter>& all() const { return all_; }
    /// What nothing has read is an error with the nearest known name, leniently a warning.
    void checkAllUsed(Reading& reading) const;

  private:
    std::string owner_;
    Location where_;
    std::vector<Parameter> all_;
    mutable std::vector<std::string> known_;
};

}  // namespace metrolux::core::pbrt
