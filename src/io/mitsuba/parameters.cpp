#include "io/mitsuba/parameters.h"

#include "io/mitsuba/properties.h"

#include <cctype>

namespace metrolux::core::mitsuba {
namespace {

/// Defaults may use earlier defaults, which could double the length at each step.
constexpr size_t kMaxLength = size_t(16) << 20;

bool isNameCharacter(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

}  // namespace

Parameters::Parameters(const std::map<std::string, std::string>& defines) {
    for (const auto& [name, value] : defines) entries_[name] = {value, true, false};
}

void Parameters::addDefault(const std::string& name, const std::string& value) {
    if (name.empty()) throw Error("found an empty name, expected a name of letters, digits and underscores");
    for (const char c : name)
        if (!isNameCharacter(c))
            throw Error("found the name \"{}\", expected letters, digits and underscores", name);
    entries_.try_emplace(name, Entry{value, false, true}).first->second.known = true;
}

std::vector<std::string> Parameters::names() const {
    std::vector<std::string> result;
    for (const auto& [name, entry] : entries_)
        if (entry.known || !entry.fromCommandLine) result.push_back(name);
    return result;
}

std::string Parameters::definedText() const {
    std::string list;
    for (const std::string& known : names()) list += (list.empty() ? "" : ", ") + known;
    return list.empty() ? "the scene declares no defaults" : "the scene declares: " + list;
}

std::string Parameters::substitute(const std::string& text) {
    if (text.find('$') == std::string::npos) return text;
    std::string result;
    for (size_t i = 0; i < text.size();) {
        if (text[i] == '\\' && i + 1 < text.size() && text[i + 1] == '$') {
            result += '$';
            i += 2;
            continue;
        }
        if (text[i] != '$') {
            result += text[i++];
            continue;
        }
        const bool braces = i + 1 < text.size() && text[i + 1] == '{';
        const size_t begin = i + (braces ? 2 : 1);
        size_t end = begin;
        while (end < text.size() && isNameCharacter(text[end])) ++end;
        const std::string whole = text.substr(begin, end - begin);
        if (braces && (end == text.size() || text[end] != '}'))
            throw Error("found \"${{{}\" without its closing brace", whole);
        auto entry = entries_.find(whole);
        while (entry == entries_.end() && !braces && end > begin + 1)
            entry = entries_.find(text.substr(begin, --end - begin));
        if (entry == entries_.end()) {
            const std::string nearest = nearestName(whole, names());
            throw Error("found ${}, which no <default> and no -D defines; {}", whole,
                        nearest.empty() ? definedText() : fmt::format("did you mean ${}?", nearest));
        }
        entry->second.known = true;
        result += entry->second.value;
        if (result.size() > kMaxLength)
            throw Error("the text is longer than {} bytes after substitution", kMaxLength);
        i = end + (braces ? 1 : 0);
    }
    return result;
}

void Parameters::checkDefinesUsed(const std::string& file) const {
    for (const auto& [name, entry] : entries_) {
        if (entry.known) continue;
        const std::string nearest = nearestName(name, names());
        throw Error("{}: -D {}={}: the scene has no <default name=\"{}\">; {}", file, name, entry.value, name,
                    nearest.empty() ? definedText() : fmt::format("did you mean \"{}\"?", nearest));
    }
}

}  // namespace metrolux::core::mitsuba
