#pragma once
#include "geometry/interaction.h"

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace metrolux::core {

/// Fraunhofer lines to which an Abbe number refers, in nanometers.
inline constexpr double kLineC = 656.2725, kLineD = 587.5618, kLineF = 486.1327;

/// An index of refraction n as a function of wavelength. Wavelengths in the coefficients are in micrometers.
/// All throw Error for coefficients with which n is not a positive number at every wavelength of
/// scattering/wavelength.h.
class Dispersion {
  public:
    /// A + B / w^2 + C / w^4 (Cauchy); one to three coefficients.
    static Dispersion cauchy(std::span<const double> coefficients);
    /// By Cauchy's equation with two coefficients, from n at the d line and the Abbe number (n_d - 1) / (n_F
    /// - n_C) > 0.
    static Dispersion abbe(double nd, double number);
    /// n^2 = 1 + sum of B_i w^2 / (w^2 - C_i) (Sellmeier); as many C as B.
    static Dispersion sellmeier(std::span<const double> b, std::span<const double> c);
    /// A glass or another material of refractive_index.cpp; case, spaces and dashes do not matter. Nothing
    /// for an unknown name.
    static std::optional<Dispersion> named(std::string_view name);
    static std::vector<std::string> names();

    double at(double nanometers) const;
    /// The smallest and the largest, of the wavelengths of scattering/wavelength.h.
    std::array<double, 2> range() const;
    /// False if n is the same at all wavelengths.
    bool varies() const;

  private:
    static constexpr size_t kMostTerms = 4;
    enum class Formula : uint8_t { Cauchy, Sellmeier };
    Dispersion(Formula formula, std::span<const double> first, std::span<const double> second);

    Formula formula_;
    std::array<double, kMostTerms> first_{}, second_{};  ///< A, B, C of Cauchy, or B and C of Sellmeier
};

/// Interior over exterior index of an interface.
class RelativeIndex {
  public:
    RelativeIndex(float constant) : constant_(constant) {}  // NOLINT(google-explicit-constructor)
    RelativeIndex(const Dispersion& interior, float exterior);

    /// Where the interaction has a wavelength, at it; else at the d line.
    float operator()(const SurfaceInteraction& si) const {
        if (!dispersion_ || !(si.wavelength > 0)) return constant_;
        return static_cast<float>(dispersion_->at(double(si.wavelength)) / double(exterior_));
    }
    float atLineD() const { return constant_; }
    bool isDispersive() const { return dispersion_ != nullptr; }
    /// Whether it is 1 at a wavelength: then a rough surface cannot tell refracted light from what goes on.
    bool passesOne() const;

  private:
    float constant_, exterior_ = 1;
    std::shared_ptr<const Dispersion> dispersion_;  ///< of the interior; null if it does not vary
};

}  // namespace metrolux::core
