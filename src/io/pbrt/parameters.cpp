#include "io/pbrt/parameters.h"

#include "base/printable.h"
#include "base/suggest.h"
#include "io/mitsuba/parser.h"

#include <algorithm>

namespace metrolux::core::pbrt {
namespace {

using Kind = Token::Kind;

const std::vector<std::string> kParameterTypes = {
    "integer", "float",  "point2",  "vector2",  "point3", "vector3", "normal3", "point", "vector",
    "normal",  "string", "texture", "spectrum", "rgb",    "color",   "xyz",     "bool",  "blackbody"};

bool isTextType(const std::string& type) { return type == "string" || type == "texture" || type == "bool"; }

void addValue(const Token& token, Parameter& parameter, MemoryBudget& memory) {
    // Vectors double: what they may take is booked before.
    constexpr size_t kMostBytes = 2 * sizeof(double);
    memory.take(kMostBytes + (token.kind == Kind::String ? token.text.size() + sizeof(std::string) : 0),
                "the scene");
    if (token.kind == Kind::Number && !isTextType(parameter.type))
        parameter.numbers.push_back(token.number);
    else if (token.kind == Kind::String && (isTextType(parameter.type) || parameter.type == "spectrum"))
        parameter.strings.emplace_back(token.text);
    else if (parameter.type == "bool" && (token.text == "true" || token.text == "false"))
        parameter.strings.emplace_back(token.text);
    else
        throw token.error(fmt::format("found {}, expected a value of \"{} {}\"",
                                      printable(std::string(token.text.substr(0, 40))), parameter.type,
                                      printable(parameter.name)));
}

/// "type name", with any space between.
Parameter declared(const Token& token) {
    const std::string text(token.text);
    const size_t start = text.find_first_not_of(" \t"), end = text.find_first_of(" \t", start);
    const size_t name = text.find_first_not_of(" \t", end);
    if (start == std::string::npos || name == std::string::npos)
        throw token.error(
            fmt::format("found \"{}\", expected \"type name\" of a parameter", printable(text)));
    Parameter result;
    result.type = text.substr(start, end - start);
    result.name = text.substr(name, text.find_last_not_of(" \t") + 1 - name);
    result.where = token.where();
    if (std::find(kParameterTypes.begin(), kParameterTypes.end(), result.type) == kParameterTypes.end()) {
        const std::string nearest = nearestName(result.type, kParameterTypes);
        throw token.error(fmt::format("found the type \"{}\" of a parameter{}, expected one of {}",
                                      printable(result.type),
                                      nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest),
                                      fmt::join(kParameterTypes, ", ")));
    }
    return result;
}

}  // namespace

std::filesystem::path Reading::find(const std::string& name, const Location& where) {
    try {
        const std::filesystem::path found = mitsuba::findFile(name, where.file, {folder});
        files.insert(found.string());
        return found;
    } catch (const Error& problem) {
        throw Error("{}: {}", where.str(), problem.what());
    }
}

void Parameters::read(Lexer& lexer, MemoryBudget& memory) {
    while (lexer.peek().kind == Kind::String) {
        Parameter parameter = declared(lexer.next());
        Token token = lexer.next();
        if (token.kind == Kind::Open) {
            for (token = lexer.next(); token.kind != Kind::Close; token = lexer.next()) {
                if (token.kind == Kind::End) throw token.error("found the end of the file, expected \"]\"");
                addValue(token, parameter, memory);
            }
        } else {
            addValue(token, parameter, memory);
        }
        const bool isTwice = std::any_of(all_.begin(), all_.end(),
                                         [&](const Parameter& p) { return p.name == parameter.name; });
        if (isTwice) throw parameter.error("found a second time, expected it once");
        all_.push_back(std::move(parameter));
    }
}

void Parameters::addDefaults(const std::vector<Parameter>& defaults) {
    for (const Parameter& parameter : defaults) {
        if (std::any_of(all_.begin(), all_.end(),
                        [&](const Parameter& p) { return p.name == parameter.name; }))
            continue;
        all_.push_back(parameter);
        all_.back().used = true;  // it is for whoever knows it
    }
}

const Parameter* Parameters::find(const std::string& name) const {
    known_.push_back(name);
    for (const Parameter& parameter : all_)
        if (parameter.name == name) {
            parameter.used = true;
            return &parameter;
        }
    return nullptr;
}

namespace {

const Parameter& expectNumbers(const Parameter& p, size_t count) {
    if (p.numbers.size() != count || isTextType(p.type))
        throw p.error(fmt::format("found {} values, expected {} number{}",
                                  p.numbers.size() + p.strings.size(), count, count == 1 ? "" : "s"));
    return p;
}

const std::string& onlyText(const Parameter& p) {
    if (p.strings.size() != 1)
        throw p.error(fmt::format("found {} values, expected one text", p.numbers.size() + p.strings.size()));
    return p.strings[0];
}

}  // namespace

double Parameters::number(const std::string& name, double fallback) const {
    const Parameter* p = find(name);
    return p ? expectNumbers(*p, 1).numbers[0] : fallback;
}

int64_t Parameters::integer(const std::string& name, int64_t fallback) const {
    const Parameter* p = find(name);
    if (!p) return fallback;
    const double value = expectNumbers(*p, 1).numbers[0];
    if (value != std::floor(value) || std::abs(value) > 2147483647.0)
        throw p->error(fmt::format("found {}, expected an integer", value));
    return static_cast<int64_t>(value);
}

bool Parameters::boolean(const std::string& name, bool fallback) const {
    const Parameter* p = find(name);
    if (!p) return fallback;
    const std::string& value = onlyText(*p);
    if (value != "true" && value != "false")
        throw p->error(fmt::format("found \"{}\", expected true or false", printable(value)));
    return value == "true";
}

std::string Parameters::string(const std::string& name, const std::string& fallback) const {
    const Parameter* p = find(name);
    return p ? onlyText(*p) : fallback;
}

std::string Parameters::requiredString(const std::string& name) const {
    const Parameter* p = find(name);
    if (!p) throw error(fmt::format("has no \"string {}\", expected one", name));
    return onlyText(*p);
}

Vec3d Parameters::vector(const std::string& name, const Vec3d& fallback) const {
    const Parameter* p = find(name);
    if (!p) return fallback;
    const std::vector<double>& v = expectNumbers(*p, 3).numbers;
    return {v[0], v[1], v[2]};
}

const std::vector<double>& Parameters::numbers(const std::string& name, size_t size) const {
    static const std::vector<double> none;
    const Parameter* p = find(name);
    if (!p) return none;
    if (p->numbers.size() % size != 0 || !p->strings.empty())
        throw p->error(fmt::format("found {} numbers, expected a multiple of {}", p->numbers.size(), size));
    return p->numbers;
}

void Parameters::ignore(std::initializer_list<const char*> names) const {
    for (const char* name : names) find(name);
}

void Parameters::checkAllUsed(Reading& reading) const {
    for (const Parameter& p : all_) {
        if (p.used) continue;
        p.used = true;
        const std::string nearest = nearestName(p.name, known_);
        reading.refuse(Error("{}: {}: found the parameter \"{} {}\", which is unknown here{}", p.where.str(),
                             owner_, p.type, printable(p.name),
                             nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)),
                       "it is left out");
    }
}

}  // namespace metrolux::core::pbrt
