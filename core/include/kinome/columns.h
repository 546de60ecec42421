#pragma once

#include <cstddef>

#include <glm/glm.hpp>

namespace kinome {

/// Maximum number of vector lanes. Blocks store values in columns (structures of arrays) whose
/// lengths are multiples of it. The padding may hold anything.
inline constexpr size_t kBlockLanes = 16;
inline constexpr size_t kColumnAlignment = kBlockLanes * sizeof(float);  ///< bytes

/// Length of a column for `count` values, with padding.
constexpr size_t padded(size_t count) {
  return (count + kBlockLanes - 1) / kBlockLanes * kBlockLanes;
}

/// 2D points or random numbers as columns. Owns nothing.
struct Columns2 {
  float* x = nullptr;
  float* y = nullptr;

  Columns2() = default;
  Columns2(float* x_column, float* y_column) : x(x_column), y(y_column) {}
  glm::vec2 at(size_t i) const { return {x[i], y[i]}; }
  void set(size_t i, const glm::vec2& value) const { x[i] = value.x, y[i] = value.y; }
  /// Returns the columns from value i on.
  Columns2 from(size_t i) const { return {x + i, y + i}; }
};

/// Points, directions or colours as columns. Owns nothing.
struct Columns3 {
  float* x = nullptr;
  float* y = nullptr;
  float* z = nullptr;

  Columns3() = default;
  Columns3(float* x_column, float* y_column, float* z_column)
      : x(x_column), y(y_column), z(z_column) {}
  glm::vec3 at(size_t i) const { return {x[i], y[i], z[i]}; }
  void set(size_t i, const glm::vec3& value) const {
    x[i] = value.x, y[i] = value.y, z[i] = value.z;
  }
  /// Returns the columns from value i on.
  Columns3 from(size_t i) const { return {x + i, y + i, z + i}; }
};

}  // namespace kinome
