#pragma once
/// Texts of attributes to values: strict, and independent of the locale. All functions throw Error that says
/// what was found and what was expected; the parser adds where.

#include "io/mitsuba/properties.h"

#include <filesystem>
#include <string_view>

namespace metrolux::core::mitsuba {

/// Finite; white space around it is allowed, anything else is not.
double parseNumber(std::string_view text);
/// parseNumber within the range of float, not rounded and rounded.
double parseWithinFloat(std::string_view text);
float parseFloat(std::string_view text);
int64_t parseInteger(std::string_view text);
bool parseBoolean(std::string_view text);
/// Parts of a list that commas and white space separate.
std::vector<std::string_view> splitList(std::string_view text);
std::vector<double> parseNumberList(std::string_view text);
/// Three numbers, or one for all components, each within the range of float.
Vec3d parseVec3(std::string_view text);
/// Linear: one or three numbers, or #rrggbb.
Rgb parseRgb(std::string_view text);
/// The same with sRGB's transfer curve, decoded to linear.
Rgb parseSrgb(std::string_view text);
/// One value, or a list of wavelength:value with ascending wavelengths in nanometers.
SpectrumValue parseSpectrum(std::string_view text);
/// As many numbers as there are channels, which in 0.6 are the channels; nothing for other texts.
std::optional<Rgb> parseChannels(std::string_view text);
/// Text file of lines "wavelength value", `#` begins a comment.
SpectrumValue readSpectrumFile(const std::filesystem::path& file);
/// Temperature in kelvin, with or without the unit K.
SpectrumValue parseBlackbody(std::string_view temperature, std::string_view scale);
/// Throws unless the wavelengths are positive and ascending and there is a value for each.
void checkSpectrum(const SpectrumValue& spectrum);

}  // namespace metrolux::core::mitsuba
