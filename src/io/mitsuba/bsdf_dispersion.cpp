/// Indices of refraction that depend on the wavelength: of no Mitsuba.

#include "base/error.h"
#include "io/mitsuba/bsdf_source.h"
#include "io/mitsuba/values.h"

#include <fmt/ranges.h>

namespace metrolux::core::mitsuba {
namespace {

Dispersion sellmeier(const std::vector<double>& numbers) {
    if (numbers.empty() || numbers.size() % 2 != 0)
        throw Error(
            "found {} coefficients of Sellmeier's equation, expected as many C as B: B1, B2, B3, C1, "
            "C2, C3",
            numbers.size());
    const std::span all(numbers);
    const size_t half = all.size() / 2;
    return Dispersion::sellmeier(all.first(half), all.last(half));
}

Dispersion glass(const std::string& name) {
    if (const auto known = Dispersion::named(name)) return *known;
    throw Error("found the material \"{}\", expected one of: {}", name,
                fmt::format("{}", fmt::join(Dispersion::names(), ", ")));
}

}  // namespace

RelativeIndex BsdfSource::indexByAbbeNumber(float interior, float exterior) const {
    const auto abbe = double(element.number("abbe", 0));
    try {
        return {Dispersion::abbe(double(interior), abbe), exterior};
    } catch (const Error& problem) {
        throw element.error(*element.find("abbe"), problem.what());
    }
}

RelativeIndex BsdfSource::indexWithDispersion(const std::string& interior) const {
    std::string given;
    for (const char* name : {"abbe", "cauchy", "sellmeier", "glass"}) {
        if (!element.has(name)) continue;
        if (!given.empty())
            throw element.error(
                *element.find(name),
                fmt::format("found \"{}\" as well as \"{}\", expected one of the two", name, given));
        given = name;
    }
    if (given.empty()) return relativeIor(interior);
    const float exterior = ior("ext_ior", "air");
    if (given == "abbe") return indexByAbbeNumber(ior("int_ior", interior), exterior);
    if (element.has("int_ior"))
        throw element.error(
            *element.find("int_ior"),
            fmt::format("found \"int_ior\" as well as \"{}\", expected one of the two", given));
    const std::string text = element.requiredString(given);
    try {
        if (given == "glass") return {glass(text), exterior};
        const std::vector<double> numbers = parseNumberList(text);
        return {given == "cauchy" ? Dispersion::cauchy(numbers) : sellmeier(numbers), exterior};
    } catch (const Error& problem) {
        throw element.error(*element.find(given), problem.what());
    }
}

}  // namespace metrolux::core::mitsuba
