#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>

#include "kinome/sensor.h"
#include "support/plugins/probe_registry.h"

/// Comparison of vectors, for tests of values in scene files.
namespace kinome::test::scene_values {

constexpr float kRounding = 1e-5f;

inline void expect_near(const Vec3& a, const Vec3& b, float tolerance = kRounding) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "component " << i;
}

}  // namespace kinome::test::scene_values
