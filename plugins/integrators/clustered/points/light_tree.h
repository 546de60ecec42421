#pragma once

#include <cstdint>
#include <vector>

#include "kinome/light_points.h"

namespace kinome {

/// A light cell: a node of the tree, which represents the points [first, first + count) of
/// LightTree::points().
struct LightCell {
  Aabb box;          ///< bounds of the points (unit directions for distant light), widened by their
                     ///< extents
  Vec3 mean{0.f};    ///< mean position; for distant light normalised, or 0 if the mean is 0
  Vec3 normal{0.f};  ///< normalised mean normal of local light, or 0
  float weight = 0;  ///< sum of the points' importance: luminance of the channels' magnitudes
  float extent = 0;  ///< sum of the points' extents [sr or area]
  /// Sum over the points of (w_i - mean w)²: the "cluster variance" of 4.2.1, as a total, so that
  /// large cells weigh more. Relative to the squared mean weight of all points of the tree, so that
  /// no unit of light leads to overflow or underflow.
  float variance = 0;
  uint32_t first = 0;
  uint32_t count = 0;
  uint32_t left = 0;  ///< index of the left child, followed by the right one; 0 for a leaf
};

/// Throws Error if the points are invalid. They may come from a third-party plugin.
void check_light_points(const LightPoints& points);

/// Complete binary tree over light points (Åkerlund 2008, 3.3; Walter et al. 2005). Points are
/// reordered so that every cell is a contiguous range. Immutable; thread-safe.
class LightTree {
 public:
  /// Splits at the median along the longest axis of the box, so that all leaves are on the last two
  /// levels. Throws Error if there are no points, or if they break the rules of LightPoints.
  explicit LightTree(LightPoints points);
  const LightPoints& points() const { return points_; }
  const std::vector<LightCell>& cells() const { return cells_; }  ///< cells()[0] is the root
  /// Importance weight of a point; 0 only if its power is 0. Negative channels, as in some
  /// photographs, count by their magnitude.
  static float weight_of(const Rgb& power) { return luminance(glm::abs(power)); }
  /// Importance weight of point i (tree order).
  float point_weight(uint32_t i) const { return weight_of(points_.power[i]); }

 private:
  LightPoints points_;
  std::vector<LightCell> cells_;
};

enum class CutCriterion {
  kVariance,   ///< Åkerlund 2008, 4.2.1
  kLuminance,  ///< 3.3, after Cheslack-Postava et al. 2007
};

/// Returns the indices of the cells of a cut: every path from the root to a leaf contains exactly
/// one. Starts at the root and splits the cell with the highest criterion (ties: larger weight,
/// then larger extent, then smaller index) until there are `size` cells, or all are leaves.
std::vector<uint32_t> select_cut(const LightTree& tree, uint32_t size, CutCriterion criterion);

}  // namespace kinome
