#include "io/mitsuba/spectrum_plugins.h"

#include "io/mitsuba/values.h"

namespace metrolux::core::mitsuba {
namespace {

std::vector<float> numbers(const Element& element, const std::string& name) {
    std::vector<float> result;
    const std::string text = element.requiredString(name);
    for (const std::string_view part : splitList(text)) result.push_back(parseFloat(part));
    return result;
}

SpectrumValue regular(const Element& element) {
    SpectrumValue spectrum;
    spectrum.values = numbers(element, "values");
    const float first = element.number("wavelength_min", 360), last = element.number("wavelength_max", 830);
    for (size_t i = 0; i < spectrum.values.size(); ++i) {
        const float t =
            static_cast<float>(i) / static_cast<float>(std::max<size_t>(1, spectrum.values.size() - 1));
        spectrum.wavelengths.push_back(lerp(t, first, last));
    }
    checkSpectrum(spectrum);
    return spectrum;
}

SpectrumValue irregular(const Element& element) {
    SpectrumValue spectrum;
    spectrum.wavelengths = numbers(element, "wavelengths");
    spectrum.values = numbers(element, "values");
    checkSpectrum(spectrum);
    return spectrum;
}

SpectrumValue uniform(const Element& element) {
    SpectrumValue spectrum;
    spectrum.values = {element.number("value", 1)};
    for (const char* bound : {"wavelength_min", "wavelength_max"})
        element.number(bound, 0);  // of no effect in RGB
    return spectrum;
}

SpectrumValue blackbody(const Element& element) {
    SpectrumValue spectrum;
    spectrum.blackbodyKelvin = element.number("temperature", 5000);
    if (!(spectrum.blackbodyKelvin > 0)) throw Error("the temperature is not positive");
    spectrum.values = {element.number("scale", 1)};
    return spectrum;
}

/// In RGB rendering the white of sRGB is D65, so that its spectrum is (1, 1, 1), or the `color` it is to
/// modulate.
RgbValue color(const Element& element) {
    RgbValue result{Rgb(1.0f)};
    if (const Property* property = element.find("color")) {
        const RgbValue* value = std::get_if<RgbValue>(&property->value);
        if (!value) throw element.error(*property, "expected an <rgb>");
        property->used = true;
        result = *value;
    }
    result.value *= element.number("scale", 1);
    return result;
}

}  // namespace

const std::vector<std::string>& spectrumPluginNames() {
    static const std::vector<std::string> names = {"uniform", "regular", "irregular", "blackbody",
                                                   "d65",     "srgb",    "srgb_d65"};
    return names;
}

bool isSpectrumPlugin(const std::string& type) {
    const auto& names = spectrumPluginNames();
    return std::find(names.begin(), names.end(), type) != names.end();
}

decltype(Property::value) spectrumFromPlugin(const Element& element) {
    decltype(Property::value) result;
    try {
        if (element.type == "uniform") {
            result = uniform(element);
        } else if (element.type == "regular") {
            result = regular(element);
        } else if (element.type == "irregular") {
            result = irregular(element);
        } else if (element.type == "blackbody") {
            result = blackbody(element);
        } else {
            result = color(element);
        }
    } catch (const Error& problem) {
        const std::string message = problem.what();
        if (message.starts_with(element.location.file)) throw;
        throw element.error(message);
    }
    std::vector<std::string> warnings;
    element.checkAllUsed(false, warnings);
    return result;
}

}  // namespace metrolux::core::mitsuba
