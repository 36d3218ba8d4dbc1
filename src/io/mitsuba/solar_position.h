#pragma once
/// Where the sun stands at a date and place: the PSA algorithm of Blanco-Muriel, Alarcon-Padilla,
/// Lopez-Moratalla and Lara-Coira, Computing the Solar Vector (Solar Energy 70(5), 2001), which both Mitsubas
/// use. Its authors give 0.5 minutes of arc for 1999 to 2015. Without refraction.

#include <cstdint>

namespace metrolux::core::mitsuba {

/// The defaults are Mitsuba's: Tokyo, 10 July 2010, 3 pm.
struct DateAndPlace {
    int64_t year = 2010, month = 7, day = 10;
    double hour = 15, minute = 0, second = 0;         ///< local time, without daylight saving
    double latitude = 35.6894, longitude = 139.6917;  ///< degrees, north and east positive
    double timezone = 9;                              ///< hours ahead of universal time
};

struct SolarPosition {
    double zenith = 0;   ///< angle from the zenith, radians
    double azimuth = 0;  ///< clockwise from north, radians in [0, 2 pi)
};

SolarPosition solarPosition(const DateAndPlace& when);

}  // namespace metrolux::core::mitsuba
