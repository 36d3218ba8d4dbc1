#include "scattering/refractive_index.h"

#include "base/error.h"
#include "scattering/wavelength.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace metrolux::core {
namespace {

struct Material {
    const char* name;
    std::array<double, 4> b, c;
};
/// Coefficients of Sellmeier's equation. Glasses: SCHOTT's catalog (2023; SF5, SF10, SF11: of 2000). Fused
/// silica: Malitson 1965. Sapphire, ordinary ray: Malitson and Dodge 1972. Diamond: Peter 1923. Water at 20
/// C: Daimon and Masumura 2007.
constexpr Material kMaterials[] = {
    {"BK7", {1.03961212, 0.231792344, 1.01046945}, {0.00600069867, 0.0200179144, 103.560653}},
    {"BAF10", {1.5851495, 0.143559385, 1.08521269}, {0.00926681282, 0.0424489805, 105.613573}},
    {"FK51A", {0.971247817, 0.216901417, 0.904651666}, {0.00472301995, 0.0153575612, 168.68133}},
    {"F2", {1.34533359, 0.209073176, 0.937357162}, {0.00997743871, 0.0470450767, 111.886764}},
    {"SF5", {1.46141885, 0.247713019, 0.949995832}, {0.0111826126, 0.0508594669, 112.041888}},
    {"SF10", {1.61625977, 0.259229334, 1.07762317}, {0.0127534559, 0.0581983954, 116.60768}},
    {"SF11", {1.73848403, 0.311168974, 1.17490871}, {0.0136068604, 0.0615960463, 121.922711}},
    {"LaSF9", {2.00029547, 0.298926886, 1.80691843}, {0.0121426017, 0.0538736236, 156.530829}},
    {"fused silica",
     {0.6961663, 0.4079426, 0.8974794},
     {0.0684043 * 0.0684043, 0.1162414 * 0.1162414, 9.896161 * 9.896161}},
    {"sapphire",
     {1.4313493, 0.65054713, 5.3414021},
     {0.0726631 * 0.0726631, 0.1193242 * 0.1193242, 18.028251 * 18.028251}},
    {"diamond", {0.3306, 4.3356}, {0.175 * 0.175, 0.106 * 0.106}},
    {"water",
     {0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688},
     {0.005101829712, 0.01821153936, 0.02620722293, 10.69792721}},
};

std::string plain(std::string_view name) {
    std::string result;
    for (const char c : name)
        if (c != ' ' && c != '-' && c != '_')
            result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    // SCHOTT's names of the kinds without lead begin with N.
    return result.starts_with("nbk") || result.starts_with("nbaf") || result.starts_with("nfk") ||
                   result.starts_with("nlasf")
               ? result.substr(1)
               : result;
}

}  // namespace

Dispersion::Dispersion(Formula formula, std::span<const double> first, std::span<const double> second)
    : formula_(formula) {
    std::copy(first.begin(), first.end(), first_.begin());
    std::copy(second.begin(), second.end(), second_.begin());
    for (const double c : second) {
        const double pole = 1e3 * std::sqrt(std::max(c, 0.0));
        if (pole >= Wavelength::kFirst && pole <= Wavelength::kLast)
            throw Error(
                "the index of refraction is infinite at {:.4g} nm, expected a number at all from {} "
                "to {} nm",
                pole, Wavelength::kFirst, Wavelength::kLast);
    }
    for (int nanometers = Wavelength::kFirst; nanometers <= Wavelength::kLast; ++nanometers) {
        const double n = at(nanometers);
        if (!(n > 0) || !std::isfinite(n) || n > 100)
            throw Error("the index of refraction at {} nm is {:.4g}, expected a positive number, 100 at most",
                        nanometers, n);
    }
}

Dispersion Dispersion::cauchy(std::span<const double> coefficients) {
    if (coefficients.empty() || coefficients.size() > 3)
        throw Error("found {} coefficients of Cauchy's equation, expected one to three: A, B, C",
                    coefficients.size());
    return {Formula::Cauchy, coefficients, {}};
}

Dispersion Dispersion::abbe(double nd, double number) {
    if (!(number > 0) || !std::isfinite(number))
        throw Error("found the Abbe number {}, expected one above zero", number);
    const auto inverseSquare = [](double nanometers) { return 1e6 / (nanometers * nanometers); };
    const double b = (nd - 1) / (number * (inverseSquare(kLineF) - inverseSquare(kLineC)));
    return cauchy(std::array{nd - b * inverseSquare(kLineD), b});
}

Dispersion Dispersion::sellmeier(std::span<const double> b, std::span<const double> c) {
    if (b.empty() || b.size() != c.size() || b.size() > kMostTerms)
        throw Error("found {} B and {} C of Sellmeier's equation, expected one to {} of both", b.size(),
                    c.size(), kMostTerms);
    return {Formula::Sellmeier, b, c};
}

std::optional<Dispersion> Dispersion::named(std::string_view name) {
    for (const Material& material : kMaterials)
        if (plain(name) == plain(material.name)) return sellmeier(material.b, material.c);
    return std::nullopt;
}

std::vector<std::string> Dispersion::names() {
    std::vector<std::string> result;
    for (const Material& material : kMaterials) result.emplace_back(material.name);
    return result;
}

double Dispersion::at(double nanometers) const {
    const double square = nanometers * nanometers * 1e-6;
    if (formula_ == Formula::Cauchy) return first_[0] + (first_[1] + first_[2] / square) / square;
    double n2 = 1;
    for (size_t i = 0; i < kMostTerms; ++i) n2 += first_[i] * square / (square - second_[i]);
    return std::sqrt(n2);
}

std::array<double, 2> Dispersion::range() const {
    double least = at(kLineD), most = least;
    for (int nanometers = Wavelength::kFirst; nanometers <= Wavelength::kLast; ++nanometers) {
        least = std::min(least, at(nanometers));
        most = std::max(most, at(nanometers));
    }
    return {least, most};
}

bool Dispersion::varies() const {
    const auto [least, most] = range();
    return least < most;
}

RelativeIndex::RelativeIndex(const Dispersion& interior, float exterior)
    : constant_(static_cast<float>(interior.at(kLineD)) / exterior), exterior_(exterior) {
    if (interior.varies()) dispersion_ = std::make_shared<const Dispersion>(interior);
}

bool RelativeIndex::passesOne() const {
    if (!dispersion_) return constant_ == 1;
    const auto [least, most] = dispersion_->range();
    return least <= double(exterior_) && most >= double(exterior_);
}

}  // namespace metrolux::core
