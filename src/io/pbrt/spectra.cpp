#include "io/pbrt/spectra.h"

#include "io/mesh_io.h"
#include "io/mitsuba/spectrum.h"
#include "scattering/ior_table.h"

#include <charconv>

namespace metrolux::core::pbrt {
namespace {

using mitsuba::SpectrumValue;

struct NamedNumber {
    const char* name;
    double value;
};
/// At 587.6 nm, of the makers' data sheets.
constexpr NamedNumber kGlasses[] = {
    {"glass-BK7", 1.5168},  {"glass-BAF10", 1.67003}, {"glass-FK51A", 1.48656}, {"glass-LASF9", 1.85025},
    {"glass-F5", 1.67271},  {"glass-SF5", 1.67271},   {"glass-F10", 1.72825},   {"glass-SF10", 1.72825},
    {"glass-F11", 1.78472}, {"glass-SF11", 1.78472}};
/// Kelvins of standard illuminants that are black bodies or close to it; D65 is white.
constexpr NamedNumber kIlluminants[] = {{"stdillum-A", 2856}, {"stdillum-D50", 5003}, {"stdillum-F5", 6350}};

SpectrumValue blackbody(double kelvin) {
    SpectrumValue result;
    result.blackbodyKelvin = static_cast<float>(kelvin);
    result.values = {1};
    return result;
}

/// "wavelength value" pairs of a parameter, or of the file that it names.
SpectrumValue pairs(const Parameter& p, Reading& reading) {
    std::vector<double> numbers = p.numbers;
    if (!p.strings.empty()) {
        MeshOptions options;
        options.memory = &reading.memory;
        const std::string text = readMeshFile(reading.find(p.strings[0], p.where), options);
        std::string plain;
        bool comment = false;
        for (const char c : text) {
            comment = c == '#' || (comment && c != '\n');
            plain.push_back(comment ? ' ' : c);
        }
        const char* at = plain.data();
        const char* const end = at + plain.size();
        for (;;) {
            while (at < end && std::isspace(static_cast<unsigned char>(*at))) ++at;
            if (at == end) break;
            double value = 0;
            const auto [rest, problem] = std::from_chars(at, end, value);
            if (problem != std::errc())
                throw p.error("found text in the file of a spectrum, expected numbers");
            numbers.push_back(value);
            at = rest;
        }
    }
    if (numbers.size() < 2 || numbers.size() % 2 != 0)
        throw p.error(
            fmt::format("found {} numbers, expected pairs of a wavelength and a value", numbers.size()));
    SpectrumValue result;
    for (size_t i = 0; i < numbers.size(); i += 2) {
        if (!std::isfinite(numbers[i]) || !std::isfinite(numbers[i + 1]) ||
            (i > 0 && !(numbers[i] > numbers[i - 2])))
            throw p.error("found wavelengths that do not rise, expected finite numbers in rising order");
        result.wavelengths.push_back(static_cast<float>(numbers[i]));
        result.values.push_back(static_cast<float>(numbers[i + 1]));
    }
    return result;
}

/// Of a spectrum that has the value 1 everywhere; others are divided by it, so that flat ones are gray.
const Rgb& colorOfFlat() {
    static const Rgb color = [] {
        SpectrumValue flat;
        flat.wavelengths = {300, 900};
        flat.values = {1, 1};
        return mitsuba::unboundedFromSpectrum(flat);
    }();
    return color;
}

/// Beyond its ends a spectrum goes on with its last value, as in pbrt's named ones; a single pair is flat.
Rgb colorOf(SpectrumValue s) {
    s.wavelengths.insert(s.wavelengths.begin(), std::min(300.0f, s.wavelengths.front() - 1));
    s.values.insert(s.values.begin(), s.values.front());
    s.wavelengths.push_back(std::max(900.0f, s.wavelengths.back() + 1));
    s.values.push_back(s.values.back());
    return mitsuba::unboundedFromSpectrum(s) / colorOfFlat();
}

Rgb three(const Parameter& p, const ColorSpace& space) {
    if (p.numbers.size() != 3)
        throw p.error(fmt::format("found {} numbers, expected 3", p.numbers.size() + p.strings.size()));
    const Rgb color(static_cast<float>(p.numbers[0]), static_cast<float>(p.numbers[1]),
                    static_cast<float>(p.numbers[2]));
    for (int c = 0; c < 3; ++c)
        if (!(color[c] >= 0) || !std::isfinite(color[c]))
            throw p.error(
                fmt::format("found {}, expected numbers of zero or more", p.numbers[static_cast<size_t>(c)]));
    return space.convert(color);
}

Rgb xyzColor(const Parameter& p) {
    const Rgb v = three(p, ColorSpace());
    const Rgb c(3.240479f * v.x - 1.537150f * v.y - 0.498535f * v.z,
                -0.969256f * v.x + 1.875991f * v.y + 0.041556f * v.z,
                0.055648f * v.x - 0.204043f * v.y + 1.057311f * v.z);
    return {std::max(c.x, 0.0f), std::max(c.y, 0.0f), std::max(c.z, 0.0f)};
}

bool isRgb(const Parameter& p) { return p.type == "rgb" || p.type == "color"; }

double kelvinOf(const Parameter& p) {
    if (p.numbers.empty() || p.numbers.size() > 2 || !(p.numbers[0] > 0))
        throw p.error("expected a temperature in kelvins");
    return p.numbers[0];
}

template <size_t N>
const double* lookUp(const NamedNumber (&table)[N], const std::string& name) {
    for (const NamedNumber& entry : table)
        if (name == entry.name) return &entry.value;
    return nullptr;
}

/// The metal in "metal-Cu-eta", or nothing.
std::optional<Rgb> metal(const std::string& name) {
    constexpr std::string_view kPrefix = "metal-";
    if (!name.starts_with(kPrefix)) return std::nullopt;
    const bool isEta = name.ends_with("-eta"), isK = name.ends_with("-k");
    if (!isEta && !isK) return std::nullopt;
    const size_t end = name.rfind('-');
    const auto found = namedConductor(name.substr(kPrefix.size(), end - kPrefix.size()));
    if (!found) return std::nullopt;
    return isEta ? found->eta : found->k;
}

}  // namespace

ColorSpace::ColorSpace(const std::string& name) {
    if (name == "srgb") return;
    isIdentity_ = false;
    if (name == "rec2020")
        rows_ = {1.6604910f,  -0.5876411f, -0.0728499f, -0.1245505f, 1.1328999f,
                 -0.0083494f, -0.0181508f, -0.1005789f, 1.1187297f};
    else if (name == "dci-p3")
        rows_ = {1.2249402f, -0.2249402f, 0,           -0.0420570f, 1.0420570f,
                 0,          -0.0196376f, -0.0786361f, 1.0982736f};
    else if (name == "aces2065-1")
        rows_ = {2.5216861f,  -1.1341310f, -0.3875550f, -0.2764799f, 1.3727190f,
                 -0.0962391f, -0.0153781f, -0.1529753f, 1.1683534f};
    else
        throw Error("found the color space \"{}\", expected srgb, rec2020, dci-p3 or aces2065-1", name);
}

Rgb ColorSpace::convert(const Rgb& c) const {
    if (isIdentity_) return c;
    Rgb result;
    for (size_t i = 0; i < 3; ++i)
        result[static_cast<int>(i)] =
            std::max(0.0f, rows_[3 * i] * c.x + rows_[3 * i + 1] * c.y + rows_[3 * i + 2] * c.z);
    return result;
}

Rgb surfaceColor(const Parameter& p, const ColorSpace& space, Reading& reading) {
    if (isRgb(p)) return three(p, space);
    if (p.type == "xyz") return xyzColor(p);
    if (p.type == "float" || p.type == "integer") {
        if (p.numbers.size() != 1)
            throw p.error(fmt::format("found {} numbers, expected 1", p.numbers.size()));
        return Rgb(static_cast<float>(p.numbers[0]));
    }
    if (p.type != "spectrum") throw p.error("expected an rgb, a spectrum or a number");
    if (p.strings.size() == 1) {
        if (const auto known = metal(p.strings[0])) return *known;
        if (const double* glass = lookUp(kGlasses, p.strings[0])) return Rgb(static_cast<float>(*glass));
        if (p.strings[0].starts_with("metal-") || p.strings[0].starts_with("glass-"))
            throw p.error(fmt::format("found the spectrum \"{}\", which is not known here", p.strings[0]));
    }
    return colorOf(pairs(p, reading));
}

Rgb lightColor(const Parameter& p, const ColorSpace& space, Reading& reading) {
    if (isRgb(p)) return three(p, space);
    if (p.type == "xyz") return xyzColor(p);
    Rgb color;
    double scale = 1;
    if (p.type == "blackbody") {
        color = mitsuba::emissionFromSpectrum(blackbody(kelvinOf(p)));
        if (p.numbers.size() == 2) scale = p.numbers[1];  // of version 3
    } else if (p.type == "spectrum") {
        if (p.strings.size() == 1 && p.strings[0] == "stdillum-D65") return Rgb(1.0f);
        if (p.strings.size() == 1 && p.strings[0].starts_with("stdillum-")) {
            const double* kelvin = lookUp(kIlluminants, p.strings[0]);
            if (!kelvin) {
                reading.refuse(
                    p.error(fmt::format("found the spectrum \"{}\", which is not known here", p.strings[0])),
                    "white stands in");
                return Rgb(1.0f);
            }
            color = mitsuba::emissionFromSpectrum(blackbody(*kelvin));
        } else {
            color = mitsuba::emissionFromSpectrum(pairs(p, reading));
        }
    } else {
        throw p.error("expected an rgb, a blackbody or a spectrum");
    }
    const float y = luminance(color);
    if (!(y > 0) || !std::isfinite(scale))
        throw p.error("is black, expected a light with a luminance above zero");
    return color * static_cast<float>(scale / double(y));
}

double indexOfRefraction(const Parameters& parameters, const std::string& name, double fallback,
                         Reading& reading) {
    const Parameter* p = parameters.find(name);
    if (!p) return fallback;
    const double value = double(luminance(surfaceColor(*p, ColorSpace(), reading)));
    if (!(value > 0))
        throw p->error(fmt::format("found {}, expected an index of refraction above zero", value));
    return value;
}

std::optional<std::string> namedGlass(const Parameters& parameters, const std::string& name) {
    constexpr std::string_view kPrefix = "glass-";
    const Parameter* p = parameters.find(name);
    if (!p || p->type != "spectrum" || p->strings.size() != 1) return std::nullopt;
    if (!lookUp(kGlasses, p->strings[0])) return std::nullopt;
    const std::string glass = p->strings[0].substr(kPrefix.size());
    // pbrt calls the flints SF5, SF10 and SF11 by shorter names.
    return glass.starts_with("F") && !glass.starts_with("FK") ? "S" + glass : glass;
}

ConductorColors conductorColors(const Parameters& parameters, const std::string& prefix,
                                const ColorSpace& space, Reading& reading) {
    const auto copper = namedConductor("Cu");
    ConductorColors result{copper->eta, copper->k};
    if (const Parameter* eta = parameters.find(prefix + "eta"))
        result.eta = surfaceColor(*eta, space, reading);
    if (const Parameter* k = parameters.find(prefix + "k")) result.k = surfaceColor(*k, space, reading);
    return result;
}

}  // namespace metrolux::core::pbrt
