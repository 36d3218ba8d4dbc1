#include "io/mitsuba/solar_position.h"

#include <cmath>
#include <numbers>

namespace metrolux::core::mitsuba {

namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// Julian day number at noon of a date of the Gregorian calendar (Fliegel & Van Flandern 1968; the divisions
/// truncate).
int64_t julianDayNumber(int64_t year, int64_t month, int64_t day) {
    const int64_t shift = (month - 14) / 12;
    return 1461 * (year + 4800 + shift) / 4 + 367 * (month - 2 - 12 * shift) / 12 -
           3 * ((year + 4900 + shift) / 100) / 4 + day - 32075;
}

}  // namespace

SolarPosition solarPosition(const DateAndPlace& when) {
    const double universalHour = when.hour - when.timezone + (when.minute + when.second / 60) / 60;
    // Days since noon of 1 January 2000, universal time (the paper's n).
    const double days = static_cast<double>(julianDayNumber(when.year, when.month, when.day)) - 0.5 +
                        universalHour / 24 - 2451545.0;

    // Ecliptic coordinates (the paper's table 1, step 2).
    const double omega = 2.1429 - 0.0010394594 * days;
    const double meanLongitude = 4.8950630 + 0.017202791698 * days;
    const double anomaly = 6.2400600 + 0.0172019699 * days;
    const double longitude = meanLongitude + 0.03341607 * std::sin(anomaly) +
                             0.00034894 * std::sin(2 * anomaly) - 0.0001134 - 0.0000203 * std::sin(omega);
    const double obliquity = 0.4090928 - 6.2140e-9 * days + 0.0000396 * std::cos(omega);

    // Celestial coordinates (step 3).
    const double rightAscension = std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude));
    const double declination = std::asin(std::sin(obliquity) * std::sin(longitude));

    // Horizontal coordinates (step 4), with the parallax of the earth's radius over its distance.
    const double siderealHours = 6.6974243242 + 0.0657098283 * days + universalHour;
    const double hourAngle = (siderealHours * 15 + when.longitude) * kDegree - rightAscension;
    const double sinLatitude = std::sin(when.latitude * kDegree),
                 cosLatitude = std::cos(when.latitude * kDegree);
    const double cosZenith =
        cosLatitude * std::cos(hourAngle) * std::cos(declination) + std::sin(declination) * sinLatitude;
    SolarPosition result;
    result.zenith = std::acos(std::fmin(std::fmax(cosZenith, -1.0), 1.0));
    result.zenith += 6371.01 / 149597890 * std::sin(result.zenith);
    result.azimuth = std::atan2(-std::sin(hourAngle),
                                std::tan(declination) * cosLatitude - sinLatitude * std::cos(hourAngle));
    if (result.azimuth < 0) result.azimuth += 2 * std::numbers::pi;
    return result;
}

}  // namespace metrolux::core::mitsuba
