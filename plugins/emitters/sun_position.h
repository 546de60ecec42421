#pragma once

#include <cmath>
#include <numbers>

#include "kinome/math.h"

/// Position of the sun: Blanco-Muriel et al., Computing the Solar Vector, 2001.
namespace kinome::sunsky {

/// A location and its local time, which is `timezone` hours ahead of UTC.
struct TimeAndPlace {
  double latitude, longitude;  ///< degrees; north and east are positive
  double timezone;
  int year, month, day;
  double hour, minute, second;
};

/// Returns the Julian day number of a date in the Gregorian calendar. A `day` beyond the end of the
/// month counts on into the following months.
inline int julian_day(int year, int month, int day) {
  const int months = (month - 14) / 12;
  return 1461 * (year + 4800 + months) / 4 + 367 * (month - 2 - 12 * months) / 12 -
         3 * ((year + 4900 + months) / 100) / 4 + day - 32075;
}

/// Returns the days since noon of 1 January 2000. As in Mitsuba, the intermediate Julian date in
/// single precision has a resolution of a quarter of a day. This moves the sun along the ecliptic
/// by up to an eighth of a degree.
inline double days_since_2000(const TimeAndPlace& at, double hours) {
  const int day = julian_day(at.year, at.month, at.day);
  const float julian = static_cast<float>(day) - 0.5f + static_cast<float>(hours) / 24;
  return double{julian - 2451545.f};
}

/// Returns the unit vector toward the sun. +z is up, -x is north and -y is east.
inline Vec3 sun_direction(const TimeAndPlace& at) {
  constexpr double kPiD = std::numbers::pi, kDegree = kPiD / 180;
  const double hours = at.hour - at.timezone + (at.minute + at.second / 60) / 60;
  const double days = days_since_2000(at, hours);
  const double omega = 2.1429 - 0.0010394594 * days;
  const double anomaly = 6.2400600 + 0.0172019699 * days;
  const double longitude = 4.8950630 + 0.017202791698 * days + 0.03341607 * std::sin(anomaly) +
                           0.00034894 * std::sin(2 * anomaly) - 0.0001134 -
                           0.0000203 * std::sin(omega);
  const double obliquity = 0.4090928 - 6.2140e-9 * days + 0.0000396 * std::cos(omega);
  const double right_ascension =
      std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude));
  const double declination = std::asin(std::sin(obliquity) * std::sin(longitude));
  const double sidereal =
      ((6.6974243242 + 0.0657098283 * days + hours) * 15 + at.longitude) * kDegree;
  const double hour_angle = sidereal - right_ascension, latitude = at.latitude * kDegree;
  const double zenith =
      std::acos(std::cos(latitude) * std::cos(hour_angle) * std::cos(declination) +
                std::sin(declination) * std::sin(latitude));
  const double azimuth =
      std::atan2(-std::sin(hour_angle), std::tan(declination) * std::cos(latitude) -
                                            std::sin(latitude) * std::cos(hour_angle));
  constexpr double kEarthRadius = 6371.01, kDistance = 149597890;  // km
  const double theta = zenith + kEarthRadius / kDistance * std::sin(zenith);
  const double phi = azimuth - kPiD;
  return Vec3(glm::dvec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                         std::cos(theta)));
}

}  // namespace kinome::sunsky
