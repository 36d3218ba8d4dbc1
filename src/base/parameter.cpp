#include "base/parameter.h"

#include "base/suggest.h"

#include <charconv>
#include <optional>

namespace metrolux::core {

namespace {

/// The whole text as a number.
template <class Number>
std::optional<Number> numberIn(const std::string& text) {
    Number value{};
    const char* const end = text.data() + text.size();
    const auto [stop, code] = std::from_chars(text.data(), end, value);
    if (code != std::errc() || stop != end) return std::nullopt;
    return value;
}

}  // namespace

std::string toText(const ParameterValue& value) {
    return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

std::string ParameterInfo::defaultText() const {
    const std::string text = toText(defaultValue);
    return meaningOfZero.empty() || text != "0" ? text : fmt::format("0: {}", meaningOfZero);
}

std::string Range::expected(bool whole) const {
    const std::string what = whole ? "a whole number" : "a number";
    if (most_ == std::numeric_limits<double>::max()) return fmt::format("{} of {} or more", what, least_);
    return whole ? fmt::format("{} from {} to {}", what, static_cast<int64_t>(least_),
                               static_cast<int64_t>(most_))
                 : fmt::format("{} from {} to {}", what, least_, most_);
}

void Range::read(const ParameterValue& value, double& to) const {
    std::optional<double> found;
    if (const auto* text = std::get_if<std::string>(&value)) found = numberIn<double>(*text);
    if (const auto* number = std::get_if<double>(&value)) found = *number;
    if (const auto* number = std::get_if<int64_t>(&value)) found = static_cast<double>(*number);
    if (!found || !(*found >= least_ && *found <= most_))  // NaN is not in it
        throw Error("found '{}', expected {}", toText(value), expected(false));
    to = *found;
}

void Range::read(const ParameterValue& value, int& to) const {
    std::optional<int64_t> found;
    if (const auto* text = std::get_if<std::string>(&value)) found = numberIn<int64_t>(*text);
    if (const auto* number = std::get_if<int64_t>(&value)) found = *number;
    if (!found || static_cast<double>(*found) < least_ || static_cast<double>(*found) > most_)
        throw Error("found '{}', expected {}", toText(value), expected(true));
    to = static_cast<int>(*found);
}

void Range::describe(ParameterInfo& info) const {
    const bool whole = info.type == ParameterType::Integer;
    info.least = least_;
    info.most = most_;
    info.meaningOfZero = meaningOfZero_;
    info.expected = expected(whole);
    info.placeholder.assign(1, whole ? 'N' : 'X');
}

void Flag::read(const ParameterValue& value, bool& to) const {
    const std::string text = toText(value);
    if (text != "true" && text != "false") throw Error("found '{}', expected true or false", text);
    to = text == "true";
}

void Flag::describe(ParameterInfo& info) const {
    info.expected = "true or false";
    info.placeholder = "true|false";
}

void Letters::read(const ParameterValue& value, std::string& to) const {
    const std::string text = toText(value);
    if (text.empty() || text.find_first_not_of(possible) != std::string::npos)
        throw Error("found '{}', expected some of the letters {}", text, fmt::join(possible, ", "));
    to = possible;
    std::erase_if(to, [&](char letter) { return text.find(letter) == std::string::npos; });
}

void Letters::describe(ParameterInfo& info) const {
    info.expected = fmt::format("some of the letters {}", fmt::join(possible, ", "));
    info.placeholder = possible;
}

const std::vector<ParameterInfo>& ParameterSet::list() const {
    static const std::vector<ParameterInfo> none;
    return list_ ? *list_ : none;
}

const ParameterInfo* ParameterSet::find(std::string_view name) const {
    for (const ParameterInfo& info : list())
        if (info.name == name) return &info;
    return nullptr;
}

const ParameterInfo* ParameterSet::findByAnyName(std::string_view name) const {
    for (const ParameterInfo& info : list())
        if (info.name == name || (!info.alias.empty() && info.alias == name)) return &info;
    return nullptr;
}

const ParameterInfo& ParameterSet::known(const std::string& name) const {
    if (const ParameterInfo* info = find(name)) return *info;
    std::vector<std::string> names;
    for (const ParameterInfo& info : list()) names.push_back(info.name);
    const std::string nearest = nearestName(name, names);
    throw Error("unknown parameter '{}'{}; known: {}", name,
                nearest.empty() ? "" : fmt::format(", did you mean '{}'?", nearest),
                names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")));
}

const ParameterValue& ParameterSet::get(const std::string& name) const {
    const ParameterInfo& info = known(name);
    const auto found = values_.find(name);
    return found != values_.end() ? found->second : info.defaultValue;
}

void ParameterSet::set(const std::string& name, const ParameterValue& value, const std::string& calledIt) {
    const ParameterInfo& info = known(name);
    try {
        values_[name] = info.checked(value);
    } catch (const Error& problem) {
        throw Error("{}: {}", calledIt, problem.what());
    }
}

}  // namespace metrolux::core
