#include "io/ies_file.h"

#include "base/error.h"
#include "io/mesh_io.h"
#include "io/mitsuba/values.h"

namespace metrolux::core {
namespace {

constexpr int64_t kMostAngles = 4096;

/// Numbers that white space and commas separate, over the ends of lines.
class Numbers {
  public:
    Numbers(const std::filesystem::path& file, std::string_view text, size_t line)
        : file_(file), text_(text), line_(line) {}

    double next(const char* what) {
        while (!text_.empty() && isSeparator(text_.front())) {
            line_ += text_.front() == '\n';
            text_.remove_prefix(1);
        }
        size_t length = 0;
        while (length < text_.size() && !isSeparator(text_[length])) ++length;
        const std::string_view word = text_.substr(0, length);
        text_.remove_prefix(length);
        if (word.empty()) throw error("the file ends", what);
        try {
            return mitsuba::parseNumber(word);
        } catch (const Error&) {
            throw error(fmt::format("found \"{}\"", word.substr(0, 40)), what);
        }
    }
    int64_t whole(const char* what, int64_t least, int64_t most) {
        const double value = next(what);
        if (!(value >= double(least) && value <= double(most)) || value != std::floor(value))
            throw error(fmt::format("found {}", value),
                        fmt::format("{}, from {} to {}", what, least, most).c_str());
        return static_cast<int64_t>(value);
    }
    float positive(const char* what) {
        const double value = next(what);
        if (!(value > 0 && value <= double(std::numeric_limits<float>::max())))
            throw error(fmt::format("found {}", value), fmt::format("{} above 0", what).c_str());
        return static_cast<float>(value);
    }
    Error error(const std::string& found, const char* expected) const {
        return Error("{}:{}: {}, expected {}", file_.string(), line_, found, expected);
    }

  private:
    static bool isSeparator(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ','; }

    const std::filesystem::path& file_;
    std::string_view text_;
    size_t line_;
};

std::string_view withoutBlanks(std::string_view line) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t'))
        line.remove_suffix(1);
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    return line;
}

std::vector<float> readAngles(Numbers& numbers, int64_t count, double most, const char* what) {
    std::vector<float> result;
    for (int64_t i = 0; i < count; ++i) {
        const double angle = numbers.next(what);
        if (!(angle >= 0 && angle <= most) || (i > 0 && !(static_cast<float>(angle) > result.back())))
            throw numbers.error(fmt::format("found {} degrees", angle),
                                fmt::format("{} that ascend within [0, {}]", what, most).c_str());
        result.push_back(static_cast<float>(angle));
    }
    return result;
}

/// What the numbers begin after: the line `TILT=...`.
struct Tilt {
    std::string_view value, rest;
    size_t line = 1;
};
Tilt findTilt(const std::filesystem::path& file, std::string_view text) {
    Tilt tilt;
    for (tilt.rest = text; !tilt.rest.empty(); ++tilt.line) {
        const size_t end = std::min(tilt.rest.find('\n'), tilt.rest.size());
        const std::string_view line = withoutBlanks(tilt.rest.substr(0, end));
        tilt.rest.remove_prefix(std::min(end + 1, tilt.rest.size()));
        if (!line.starts_with("TILT=")) continue;
        tilt.value = line.substr(5);
        ++tilt.line;
        return tilt;
    }
    throw Error("{}: found no line TILT=..., expected a photometric web (IES LM-63)", file.string());
}

}  // namespace

PhotometricWeb readIes(const std::filesystem::path& file, std::vector<std::string>& warnings,
                       MemoryBudget* memory) {
    MeshOptions options;
    options.memory = memory;
    const std::string text = readMeshFile(file, options);
    const Tilt tilt = findTilt(file, text);
    Numbers numbers(file, tilt.rest, tilt.line);
    if (tilt.value == "INCLUDE") {
        numbers.whole("the geometry of the tilt", 1, 3);
        const int64_t pairs = numbers.whole("a number of angles of tilt", 0, kMostAngles);
        for (int64_t i = 0; i < 2 * pairs; ++i) numbers.next("angles and factors of the tilt");
    }
    if (tilt.value != "NONE")
        warnings.push_back(
            fmt::format("{}: the tilt of the lamp (TILT={}) has no effect", file.string(), tilt.value));

    numbers.whole("a number of lamps", 0, 1 << 20);
    numbers.next("the lumens of a lamp");
    float factor = numbers.positive("a multiplier");
    const int64_t verticals = numbers.whole("a number of vertical angles", 1, kMostAngles),
                  horizontals = numbers.whole("a number of horizontal angles", 1, kMostAngles);
    const int64_t type = numbers.whole("a type of photometry", 1, 3);
    if (type != 1)
        throw numbers.error(
            fmt::format("found photometry of type {}, which is not supported", type == 2 ? "B" : "A"),
            "type C (1)");
    numbers.whole("units, 1 or 2", 1, 2);
    for (const char* what : {"the width of the luminaire", "its length", "its height"}) numbers.next(what);
    factor *= numbers.positive("a ballast factor");
    numbers.next("the ballast's photometric factor");
    numbers.next("the input power");

    if (memory)
        memory->require(uint64_t(verticals) * uint64_t(horizontals) * sizeof(float), "the photometric web");
    PhotometricWeb web;
    web.vertical = readAngles(numbers, verticals, 180, "vertical angles");
    web.horizontal = readAngles(numbers, horizontals, 360, "horizontal angles");
    for (int64_t i = 0; i < verticals * horizontals; ++i) {
        const auto value = static_cast<float>(numbers.next("candelas")) * factor;
        if (!(value >= 0) || !std::isfinite(value))
            throw numbers.error(fmt::format("found {} candelas", value), "finite ones, not negative");
        web.values.push_back(value);
    }
    return web;
}

}  // namespace metrolux::core
