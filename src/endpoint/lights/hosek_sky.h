#pragma once
/// The clear sky of Hosek & Wilkie, An Analytic Model for Full Spectral Sky-Dome Radiance (SIGGRAPH 2012),
/// fitted for linear RGB.

#include "base/math.h"
#include "endpoint/lights/hosek_sky_data.h"

namespace metrolux::core {

class HosekSky {
  public:
    /// Turbidity in [1, 10], ground albedo in [0, 1]; the sun's elevation above the horizon in radians, in
    /// [0, pi/2]. Throws Error otherwise.
    HosekSky(float turbidity, const Rgb& albedo, float elevation);

    /// Radiance at the angle theta (in [0, pi/2]) from the zenith and gamma from the sun. The data integrate
    /// spectral radiance in W / (m^2 sr nm) over the observer's curves; as Mitsuba does, the result is
    /// divided by the integral of the observer's Y: an equal-energy spectrum of radiance 1 has luminance 1.
    Rgb radiance(double cosTheta, double gamma) const;

  private:
    double shape_[kHosekChannels][kHosekShapes];
    double scale_[kHosekChannels];
};

}  // namespace metrolux::core
