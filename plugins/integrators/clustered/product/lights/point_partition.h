#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kinome/math.h"

namespace kinome {

class Scheduler;

/// A position in a scene with its normal, where a light point may be.
struct OrientedPoint {
  Vec3 position{0.f};
  Vec3 normal{0.f};  ///< unit, or 0 for an emitter without a surface
};

/// Divides positions and normals into cells, which are small where there is much light. It is a kd
/// tree over position and normal. The cell with the highest flux x variance is split next, at its
/// mean. Each point belongs to one cell, even if the tree wasn't built from it. Immutable;
/// thread-safe.
class PointPartition {
 public:
  PointPartition() = default;
  /// Makes at most `count` cells, and at most one for each distinct point. Uses the threads of
  /// `scheduler` if it isn't nullptr, with the same result. Sets `cells`, if it isn't nullptr, to
  /// the index of the cell of each point.
  PointPartition(std::span<const OrientedPoint> points, std::span<const float> flux,
                 uint32_t count, const Scheduler* scheduler = nullptr,
                 std::vector<uint32_t>* cells = nullptr);

  uint32_t size() const { return size_; }
  /// Index of the cell that contains the point. Cells are numbered in the order of the tree, so
  /// that consecutive cells are near one another.
  uint32_t cell_of(const OrientedPoint& point) const;

 private:
  static constexpr int kAxes = 6;
  using Coordinates = std::array<float, kAxes>;
  struct Node {
    int16_t axis = -1;  ///< -1: a leaf
    float split = 0;    ///< points with a smaller coordinate are in `below`
    uint32_t below = 0, above = 0;
    uint32_t cell = 0;
  };
  struct Builder;
  Coordinates coordinates(const OrientedPoint& point) const;
  void number_cells();

  float normal_scale_ = 1;  ///< length that the unit of a normal is worth
  uint32_t size_ = 0;
  std::vector<Node> nodes_;
};

}  // namespace kinome
