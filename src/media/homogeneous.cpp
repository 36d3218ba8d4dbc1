#include "base/error.h"
#include "media/medium.h"

namespace metrolux::core {
namespace {

class HomogeneousMedium final : public Medium {
  public:
    HomogeneousMedium(const Rgb& extinction, const Rgb& albedo, PhaseFunctionPtr phase)
        : Medium(std::move(phase)), extinction_(extinction), scattering_(extinction * albedo) {}

    Rgb thickness(const Vec3f&, const Vec3f&, float length) const override {
        // Not 0 * infinity, where a channel passes.
        const auto of = [&](float sigma) { return sigma > 0 ? sigma * length : 0.0f; };
        return {of(extinction_.x), of(extinction_.y), of(extinction_.z)};
    }
    std::optional<Flight> fly(const Vec3f& origin, const Vec3f& direction, float length, int channel,
                              float target) const override {
        const float sigma = extinction_[channel];
        if (!(target < sigma * length)) return std::nullopt;  // as for sigma = 0
        const float distance = target / sigma;
        return Flight{distance, thickness(origin, direction, distance)};
    }
    Rgb extinction(const Vec3f&) const override { return extinction_; }
    Rgb scattering(const Vec3f&) const override { return scattering_; }
    bool scatters() const override { return !isBlack(scattering_); }

  private:
    Rgb extinction_, scattering_;
};

}  // namespace

MediumPtr makeHomogeneousMedium(const Rgb& extinction, const Rgb& albedo, PhaseFunctionPtr phase) {
    for (int channel = 0; channel < 3; ++channel) {
        if (!(extinction[channel] >= 0) || !std::isfinite(extinction[channel]))
            throw Error(
                "homogeneous: the extinction is {} in channel {}, expected a finite number that is not "
                "negative",
                extinction[channel], channel);
        if (!(albedo[channel] >= 0 && albedo[channel] <= 1))
            throw Error("homogeneous: the albedo is {} in channel {}, expected one in [0, 1]",
                        albedo[channel], channel);
    }
    return std::make_shared<HomogeneousMedium>(extinction, albedo, std::move(phase));
}

}  // namespace metrolux::core
