#include "app/option_parsing.h"

#include "base/error.h"

#include <charconv>
#include <cmath>
#include <fstream>

namespace metrolux::core::app {
namespace {

/// Reads a number at the beginning of `rest` and removes it; false if there is none.
template <class Number>
bool takeNumber(std::string_view& rest, Number& value) {
    const auto [end, code] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (code != std::errc()) return false;
    rest.remove_prefix(static_cast<size_t>(end - rest.data()));
    return true;
}

bool takeSeparator(std::string_view& rest, char separator) {
    if (rest.empty() || rest.front() != separator) return false;
    rest.remove_prefix(1);
    return true;
}

/// Seconds of the unit at the beginning of `rest`, which is removed; 0 if it is none.
double takeTimeUnit(std::string_view& rest) {
    if (takeSeparator(rest, 's')) return 1;
    if (takeSeparator(rest, 'm')) return 60;
    if (takeSeparator(rest, 'h')) return 3600;
    return rest.empty() ? 1 : 0;
}

}  // namespace

double parseInterval(const std::string& text) {
    constexpr double kLongest = 100 * 365.25 * 86400;
    std::string_view rest = text;
    double seconds = 0;
    do {
        double number = 0;
        if (!takeNumber(rest, number) || !std::isfinite(number) || number < 0)
            throw Error("'{}' is not a time, expected for example 90s, 5m or 1h30m", text);
        const double unit = takeTimeUnit(rest);
        if (unit == 0) throw Error("'{}' is not a time: the units are s, m and h", text);
        seconds += number * unit;
    } while (!rest.empty());
    if (!(seconds <= kLongest)) throw Error("'{}' is longer than a hundred years", text);
    return seconds;
}

double parseDuration(const std::string& text) {
    const double seconds = parseInterval(text);
    if (!(seconds > 0)) throw Error("'{}' is not a time to render for: it must be longer than zero", text);
    return seconds;
}

double parseRelativeError(const std::string& text) {
    std::string_view rest = text;
    double error = 0;
    const bool isNumber = takeNumber(rest, error) && std::isfinite(error) && error > 0;
    if (isNumber && takeSeparator(rest, '%')) error /= 100;
    if (!isNumber || !rest.empty())
        throw Error("--error {}: expected a number above zero such as 0.02 or 2%", text);
    if (error > 1) throw Error("--error {}: found more than the image itself, expected at most 100%", text);
    return error;
}

size_t parseMemory(const std::string& text) {
    std::string_view rest = text;
    double number = 0;
    const bool isNumber = takeNumber(rest, number) && std::isfinite(number) && number > 0;
    double unit = 1;
    if (!rest.empty()) {
        const size_t power = std::string_view("kKmMgGtT").find(rest.front());
        if (power != std::string_view::npos) {
            unit = std::exp2(10.0 * static_cast<double>(power / 2 + 1));
            rest.remove_prefix(1);
        }
        if (rest == "B" || rest == "iB") rest = {};
    }
    if (!isNumber || !rest.empty() || number * unit >= 0x1p62)
        throw Error("'{}' is not an amount of memory, expected for example 4G or 512M", text);
    return static_cast<size_t>(number * unit);
}

Resolution parseResolution(const std::string& text) {
    std::string_view rest = text;
    Resolution size;
    if (!takeNumber(rest, size.width) || !takeSeparator(rest, 'x') || !takeNumber(rest, size.height) ||
        !rest.empty())
        throw Error("'{}' is not a resolution, expected WIDTHxHEIGHT, for example 1280x720", text);
    return size;
}

Crop parseCrop(const std::string& text) {
    std::string_view rest = text;
    Crop r;
    if (!takeNumber(rest, r.x) || !takeSeparator(rest, ',') || !takeNumber(rest, r.y) ||
        !takeSeparator(rest, ',') || !takeNumber(rest, r.width) || !takeSeparator(rest, ',') ||
        !takeNumber(rest, r.height) || !rest.empty())
        throw Error("'{}' is not a crop, expected x,y,width,height in pixels, for example 100,50,320,240",
                    text);
    return r;
}

Range parseRange(const std::string& text) {
    std::string_view rest = text;
    Range range;
    const bool first = takeNumber(rest, range.first);
    range.last = range.first;
    const bool last = rest.empty() || (takeSeparator(rest, '-') && takeNumber(rest, range.last));
    if (!first || !last || !rest.empty() || range.last < range.first)
        throw Error("'{}' is not a range of numbers, expected for example 3 or 0-7", text);
    return range;
}

std::vector<std::string> commandWords() {
    std::ifstream file("/proc/self/cmdline", std::ios::binary);
    std::vector<std::string> words;
    for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
    return words;
}

std::map<std::string, std::string> parseDefines(const std::vector<std::string>& texts) {
    std::map<std::string, std::string> defines;
    for (const std::string& text : texts) {
        const size_t equals = text.find('=');
        if (equals == std::string::npos || equals == 0)
            throw Error("-D {}: expected name=value, for example -D spp=16", text);
        defines[text.substr(0, equals)] = text.substr(equals + 1);
    }
    return defines;
}

}  // namespace metrolux::core::app
