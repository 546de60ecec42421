#pragma once

/// Tables of the Hošek-Wilkie sky and sun; see sunsky_model.h and make_sunsky_tables.py.
namespace kinome::sunsky {

inline constexpr int kTurbidities = 10;
inline constexpr int kAlbedos = 2;
inline constexpr int kControlPoints = 6;
inline constexpr int kShapeParameters = 9;
inline constexpr int kElevations = 30;

extern const float kSkyShape[kTurbidities * kAlbedos * kControlPoints * 3 * kShapeParameters];
extern const float kSkyRadiance[kTurbidities * kAlbedos * kControlPoints * 3];
extern const float kSunRadiance[kTurbidities * kElevations * 3];

}  // namespace kinome::sunsky
