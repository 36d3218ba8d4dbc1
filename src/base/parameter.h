#pragma once
/// Parameters that describe themselves. A plain struct names each of its members once, with the values that
/// it may have and a line of help; what a default-constructed struct holds are the defaults:
///
///     struct MergingParameters {
///         double radius = 0;
///         template <class V>
///         void visit(V&& v) {
///             v("radius", radius, Range::from(0).zeroIs("from the pixel size"), "first merging radius");
///         }
///     };
///
/// A struct may be made of others: v(merging) visits all members of that one. The values that a member may
/// have are an object that reads it from a ParameterValue, writes it as one, and describes what it expects:
/// those below, or one for a type of its own.

#include "base/error.h"

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace metrolux::core {

/// A value whose parameter is elsewhere. A string is a text that is read as what the parameter is, so that
/// "0.5" may stand for a number.
using ParameterValue = std::variant<bool, int64_t, double, std::string>;
/// Values by the name of their parameters.
using ParameterValues = std::map<std::string, ParameterValue>;
/// As one writes it: true, 3, 0.25, kelemen.
std::string toText(const ParameterValue& value);

enum class ParameterType { Boolean, Integer, Real, Text };

/// What there is to know of a parameter.
struct ParameterInfo {
    std::string name;   ///< lower case, words joined by underscores
    std::string alias;  ///< another name, of another renderer or another spelling; may be empty
    std::string help;   ///< one line, without default and range
    ParameterType type = ParameterType::Text;
    ParameterValue defaultValue;
    std::string meaningOfZero;  ///< of a number whose zero stands for something: "from the pixel size"
    double least = -std::numeric_limits<double>::infinity();  ///< of numbers
    double most = std::numeric_limits<double>::infinity();
    std::vector<std::string> choices;  ///< all values, where a text is one of a few
    std::string expected;              ///< "a number from 0 to 1"
    std::string placeholder;           ///< in a usage line: X, N, kelemen|adaptive
    /// A value in the parameter's own type and form. Throws Error "found ..., expected ...".
    std::function<ParameterValue(const ParameterValue&)> checked;

    /// "0.75", or "0: from the pixel size".
    std::string defaultText() const;
};

/// The numbers from `least` to `most`, of a double or an int.
class Range {
  public:
    static Range between(double least, double most) { return {least, most}; }
    static Range from(double least) { return {least, std::numeric_limits<double>::max()}; }
    Range zeroIs(const char* meaning) const {
        Range copy = *this;
        copy.meaningOfZero_ = meaning;
        return copy;
    }
    void read(const ParameterValue& value, double& to) const;
    void read(const ParameterValue& value, int& to) const;
    static ParameterValue write(double value) { return value; }
    static ParameterValue write(int value) { return int64_t{value}; }
    void describe(ParameterInfo& info) const;

  private:
    Range(double least, double most) : least_(least), most_(most) {}
    std::string expected(bool whole) const;
    double least_, most_;
    const char* meaningOfZero_ = "";
};

/// Yes or no.
struct Flag {
    void read(const ParameterValue& value, bool& to) const;
    static ParameterValue write(bool value) { return value; }
    void describe(ParameterInfo& info) const;
};

/// One of a few values that have names.
template <class T>
struct Choices {
    std::vector<std::pair<std::string, T>> all;

    void read(const ParameterValue& value, T& to) const {
        const std::string text = toText(value);
        for (const auto& [name, meaning] : all) {
            if (name != text) continue;
            to = meaning;
            return;
        }
        throw Error("found '{}', expected {}", text, fmt::join(names(), " or "));
    }
    ParameterValue write(const T& value) const {
        for (const auto& [name, meaning] : all)
            if (meaning == value) return name;
        throw std::logic_error("a value that has no name");
    }
    void describe(ParameterInfo& info) const {
        info.choices = names();
        info.expected = fmt::format("{}", fmt::join(info.choices, " or "));
        info.placeholder = fmt::format("{}", fmt::join(info.choices, "|"));
    }
    std::vector<std::string> names() const {
        std::vector<std::string> result;
        for (const auto& [name, meaning] : all) result.push_back(name);
        return result;
    }
};

/// Some of the letters, at least one, in any order.
struct Letters {
    std::string possible;
    void read(const ParameterValue& value, std::string& to) const;
    static ParameterValue write(const std::string& value) { return value; }
    void describe(ParameterInfo& info) const;
};

/// A parameter's name, and another that it is known by.
struct ParameterName {
    ParameterName(const char* name, const char* other = "") : own(name), alias(other) {}
    const char* own;
    const char* alias;
};

/// All parameters of a struct, in the order in which it names them.
class ListParameters {
  public:
    template <class T, class Values>
    void operator()(const ParameterName& name, T& member, const Values& values, const char* help) {
        ParameterInfo info;
        info.name = name.own;
        info.alias = name.alias;
        info.help = help;
        info.defaultValue = values.write(member);
        info.type = static_cast<ParameterType>(info.defaultValue.index());
        values.describe(info);
        info.checked = [values](const ParameterValue& value) {
            T checked{};
            values.read(value, checked);
            return values.write(checked);
        };
        list.push_back(std::move(info));
    }
    template <class Group>
    void operator()(Group& group) {
        group.visit(*this);
    }
    std::vector<ParameterInfo> list;
};

template <class Parameters>
std::vector<ParameterInfo> parametersOf() {
    ListParameters lister;
    Parameters{}.visit(lister);
    return std::move(lister.list);
}

/// Values for all parameters of a list: their defaults, and what has been set.
class ParameterSet {
  public:
    ParameterSet() = default;
    /// The list outlives the set.
    explicit ParameterSet(const std::vector<ParameterInfo>& list) : list_(&list) {}

    const std::vector<ParameterInfo>& list() const;
    /// Null if there is no parameter of this name.
    const ParameterInfo* find(std::string_view name) const;
    /// As find(), by either name.
    const ParameterInfo* findByAnyName(std::string_view name) const;
    /// Throws Error for an unknown name.
    const ParameterValue& get(const std::string& name) const;
    /// Throws Error that names the parameter, what was found and what was expected. `calledIt`: what the
    /// message calls it.
    void set(const std::string& name, const ParameterValue& value, const std::string& calledIt);
    void set(const std::string& name, const ParameterValue& value) { set(name, value, name); }

    /// The values in a struct, all of whose parameters are in the list.
    template <class Parameters>
    Parameters as() const;

  private:
    const ParameterInfo& known(const std::string& name) const;
    const std::vector<ParameterInfo>* list_ = nullptr;
    ParameterValues values_;
};

/// Gives the members of a struct their values.
struct AssignParameters {
    const ParameterSet& from;
    template <class T, class Values>
    void operator()(const ParameterName& name, T& member, const Values& values, const char*) const {
        values.read(from.get(name.own), member);
    }
    template <class Group>
    void operator()(Group& group) const {
        group.visit(*this);
    }
};

template <class Parameters>
Parameters ParameterSet::as() const {
    Parameters result;
    result.visit(AssignParameters{*this});
    return result;
}

}  // namespace metrolux::core
