#include "io/mitsuba/values.h"

#include "image/tonemap.h"

#include <charconv>
#include <cmath>
#include <fstream>

namespace metrolux::core::mitsuba {
namespace {

constexpr uintmax_t kMaxSpectrumBytes = 16u << 20;

std::string_view trimmed(std::string_view text) {
    const size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

/// For messages: long and unprintable texts are cut and replaced.
std::string quoted(std::string_view text) {
    std::string result = "\"";
    for (const char c : text.substr(0, 40)) result += static_cast<unsigned char>(c) < 32 ? ' ' : c;
    return result + (text.size() > 40 ? "...\"" : "\"");
}

/// std::from_chars knows no plus sign.
std::string_view withoutPlus(std::string_view text) {
    return text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+' ? text.substr(1) : text;
}

}  // namespace

double parseNumber(std::string_view text) {
    const std::string_view body = withoutPlus(trimmed(text));
    double value = 0;
    const auto [end, code] = std::from_chars(body.data(), body.data() + body.size(), value);
    if (body.empty() || code == std::errc::invalid_argument || end != body.data() + body.size())
        throw Error("found {}, expected a number", quoted(text));
    if (code == std::errc::result_out_of_range) {
        const size_t exponent = body.find_first_of("eE");
        if (exponent != std::string_view::npos && exponent + 1 < body.size() && body[exponent + 1] == '-')
            return 0;
        throw Error("found {}, expected a number within the range of double precision", quoted(text));
    }
    if (!std::isfinite(value)) throw Error("found {}, expected a finite number", quoted(text));
    return value;
}

double parseWithinFloat(std::string_view text) {
    const double value = parseNumber(text);
    if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()))
        throw Error("found {}, expected a number within the range of single precision", quoted(text));
    return value;
}

float parseFloat(std::string_view text) { return static_cast<float>(parseWithinFloat(text)); }

int64_t parseInteger(std::string_view text) {
    const std::string_view body = withoutPlus(trimmed(text));
    int64_t value = 0;
    const auto [end, code] = std::from_chars(body.data(), body.data() + body.size(), value);
    if (code == std::errc::result_out_of_range)
        throw Error("found {}, expected an integer of at most 64 bits", quoted(text));
    if (body.empty() || code != std::errc() || end != body.data() + body.size())
        throw Error("found {}, expected an integer", quoted(text));
    return value;
}

bool parseBoolean(std::string_view text) {
    std::string lower;
    for (const char c : trimmed(text))
        lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (lower == "true") return true;
    if (lower == "false") return false;
    throw Error("found {}, expected \"true\" or \"false\"", quoted(text));
}

std::vector<std::string_view> splitList(std::string_view text) {
    constexpr std::string_view kSeparators = ", \t\r\n";
    std::vector<std::string_view> parts;
    for (size_t begin = text.find_first_not_of(kSeparators); begin != std::string_view::npos;) {
        const size_t end = text.find_first_of(kSeparators, begin);
        parts.push_back(text.substr(begin, end == std::string_view::npos ? end : end - begin));
        begin = text.find_first_not_of(kSeparators, end);
    }
    return parts;
}

std::vector<double> parseNumberList(std::string_view text) {
    std::vector<double> values;
    for (const std::string_view part : splitList(text)) values.push_back(parseNumber(part));
    return values;
}

Vec3d parseVec3(std::string_view text) {
    const auto parts = splitList(text);
    if (parts.size() != 1 && parts.size() != 3)
        throw Error("found {} numbers in {}, expected one or three", parts.size(), quoted(text));
    if (parts.size() == 1) return Vec3d(parseWithinFloat(parts[0]));
    return {parseWithinFloat(parts[0]), parseWithinFloat(parts[1]), parseWithinFloat(parts[2])};
}

Rgb parseRgb(std::string_view text) {
    const std::string_view body = trimmed(text);
    if (body.starts_with('#')) {
        uint32_t code = 0;
        const auto [end, status] = std::from_chars(body.data() + 1, body.data() + body.size(), code, 16);
        if (body.size() != 7 || status != std::errc() || end != body.data() + body.size())
            throw Error("found {}, expected a color of the form #rrggbb", quoted(text));
        return {static_cast<float>(code >> 16) / 255.0f, static_cast<float>((code >> 8) & 255u) / 255.0f,
                static_cast<float>(code & 255u) / 255.0f};
    }
    const Vec3f value(parseVec3(text));
    return {value.x, value.y, value.z};
}

Rgb parseSrgb(std::string_view text) {
    const Rgb encoded = parseRgb(text);
    return {decodeSrgb(encoded.x), decodeSrgb(encoded.y), decodeSrgb(encoded.z)};
}

void checkSpectrum(const SpectrumValue& spectrum) {
    if (spectrum.wavelengths.size() < 2)
        throw Error("found a spectrum of {} samples, expected two or more", spectrum.wavelengths.size());
    if (spectrum.wavelengths.size() != spectrum.values.size())
        throw Error("found {} wavelengths and {} values, expected as many of both",
                    spectrum.wavelengths.size(), spectrum.values.size());
    if (!(spectrum.wavelengths.front() > 0))
        throw Error("found the wavelength {}, expected positive nanometers", spectrum.wavelengths.front());
    for (size_t i = 1; i < spectrum.wavelengths.size(); ++i)
        if (!(spectrum.wavelengths[i] > spectrum.wavelengths[i - 1]))
            throw Error("found the wavelength {} after {}, expected ascending wavelengths",
                        spectrum.wavelengths[i], spectrum.wavelengths[i - 1]);
}

SpectrumValue parseSpectrum(std::string_view text) {
    SpectrumValue spectrum;
    if (text.find(':') == std::string_view::npos) {
        const auto parts = splitList(text);
        if (parts.size() != 1)
            throw Error("found {}, expected one number or a list of wavelength:value", quoted(text));
        spectrum.values.push_back(parseFloat(parts[0]));
        return spectrum;
    }
    for (const std::string_view part : splitList(text)) {
        const size_t colon = part.find(':');
        if (colon == std::string_view::npos)
            throw Error("found {} in a list, expected wavelength:value", quoted(part));
        spectrum.wavelengths.push_back(parseFloat(part.substr(0, colon)));
        spectrum.values.push_back(parseFloat(part.substr(colon + 1)));
    }
    checkSpectrum(spectrum);
    return spectrum;
}

std::optional<Rgb> parseChannels(std::string_view text) {
    if (text.find(':') != std::string_view::npos || splitList(text).size() != 3) return std::nullopt;
    return parseRgb(text);
}

SpectrumValue readSpectrumFile(const std::filesystem::path& file) {
    std::error_code code;
    const uintmax_t size = std::filesystem::file_size(file, code);
    std::ifstream stream(file, std::ios::binary);
    if (code || !stream) throw Error("{}: cannot be read", file.string());
    if (size > kMaxSpectrumBytes) throw Error("{}: too large for a spectrum ({} bytes)", file.string(), size);
    SpectrumValue spectrum;
    std::string line;
    try {
        for (int number = 1; std::getline(stream, line); ++number) {
            const auto parts = splitList(std::string_view(line).substr(0, line.find('#')));
            if (parts.empty()) continue;
            try {
                if (parts.size() != 2)
                    throw Error("found {}, expected a wavelength and a value", quoted(trimmed(line)));
                spectrum.wavelengths.push_back(parseFloat(parts[0]));
                spectrum.values.push_back(parseFloat(parts[1]));
            } catch (const Error& problem) {
                // A file that does not begin as a spectrum may be any file of this machine.
                if (spectrum.values.empty())
                    throw Error("line {}: expected a wavelength and a value, two numbers", number);
                throw Error("line {}: {}", number, problem.what());
            }
        }
        checkSpectrum(spectrum);
    } catch (const Error& problem) {
        throw Error("{}: {}", file.string(), problem.what());
    }
    return spectrum;
}

SpectrumValue parseBlackbody(std::string_view temperature, std::string_view scale) {
    std::string_view body = trimmed(temperature);
    if (body.ends_with('K') || body.ends_with('k')) body.remove_suffix(1);
    SpectrumValue spectrum;
    spectrum.blackbodyKelvin = parseFloat(body);
    if (!(spectrum.blackbodyKelvin > 0))
        throw Error("found the temperature {}, expected positive kelvins", quoted(temperature));
    spectrum.values.push_back(scale.empty() ? 1.0f : parseFloat(scale));
    return spectrum;
}

}  // namespace metrolux::core::mitsuba
