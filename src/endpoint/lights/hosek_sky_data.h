#pragma once
/// The coefficients of Hosek & Wilkie's sky model for linear RGB (see hosek_sky.h).

namespace metrolux::core {

inline constexpr int kHosekChannels = 3;      ///< red, green, blue
inline constexpr int kHosekAlbedos = 2;       ///< ground albedo 0 and 1
inline constexpr int kHosekTurbidities = 10;  ///< 1 to 10
inline constexpr int kHosekControls = 6;      ///< control points over the sun's elevation
inline constexpr int kHosekShapes = 9;  ///< A to I of the paper, in the order of its sample implementation

extern const float kHosekSkyShape[kHosekChannels][kHosekAlbedos][kHosekTurbidities][kHosekControls]
                                 [kHosekShapes];
extern const float kHosekSkyRadiance[kHosekChannels][kHosekAlbedos][kHosekTurbidities][kHosekControls];

}  // namespace metrolux::core
