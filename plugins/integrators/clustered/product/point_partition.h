#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kinome/math.h"

namespace kinome {

/// A place in a scene and which way it faces: where a light point may be.
struct OrientedPoint {
  Vec3 position{0.f};
  Vec3 normal{0.f};  ///< unit, or 0 for a light without a surface
};

/// Divides places and directions into cells, small where much light is: a kd tree over position and
/// normal, whose cell of the highest flux x variance is split next, at its mean. Any point lies in
/// one cell, whether it was among those that the tree was made of or not. Immutable; thread-safe.
class PointPartition {
 public:
  PointPartition() = default;
  /// At most `count` cells, and no more than there are different points.
  PointPartition(std::span<const OrientedPoint> points, std::span<const float> flux,
                 uint32_t count);

  uint32_t size() const { return size_; }
  /// Cells are numbered along the tree: neighbours are near one another.
  uint32_t cell_of(const OrientedPoint& point) const;

 private:
  static constexpr int kAxes = 6;
  using Coordinates = std::array<float, kAxes>;
  struct Node {
    int16_t axis = -1;  ///< -1: a leaf
    float split = 0;    ///< points below go to `below`
    uint32_t below = 0, above = 0;
    uint32_t cell = 0;
  };
  struct Builder;
  Coordinates coordinates(const OrientedPoint& point) const;
  void number(uint32_t node);

  float normal_scale_ = 1;  ///< of normals, in units of length
  uint32_t size_ = 0;
  std::vector<Node> nodes_;
};

}  // namespace kinome
