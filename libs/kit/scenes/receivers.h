#pragma once

#include <functional>
#include <vector>

#include "kinome/color.h"
#include "kinome/distribution.h"
#include "kinome/math.h"
#include "kit/statistics/random.h"
#include "kit/statistics/statistics.h"

namespace kinome::check {

/// A virtual surface in the path of light: a rectangle or a sphere. It is not part of the scene.
/// Its two sides are measured separately. Its points have area-preserving coordinates in [0, 1]².
class Receiver {
 public:
  /// Returns the rectangle with these half extents along frame.s and frame.t.
  static Receiver plane(const Vec3& centre, const Frame& frame, const Vec2& half_extent);
  static Receiver sphere(const Vec3& centre, float radius);

  struct Point {
    Vec3 p, n;  ///< world space; n is the unit normal of the front
  };
  Point at(const Vec2& uv) const;
  double area() const { return area_; }
  const char* name() const { return is_sphere_ ? "sphere" : "plane"; }

  /// Calls fn(uv, is_front) for each crossing of the ray from `o` along the unit vector `d`, with
  /// the side that it arrives at.
  template <class Function>
  void for_each_crossing(const Vec3& o, const Vec3& d, Function&& fn) const {
    Crossing crossings[2];
    const int count = crossings_of(o, d, crossings);
    for (int i = 0; i < count; ++i) fn(crossings[i].uv, crossings[i].is_front);
  }

 private:
  struct Crossing {
    Vec2 uv;
    bool is_front;
  };
  int crossings_of(const Vec3& o, const Vec3& d, Crossing (&out)[2]) const;

  bool is_sphere_ = false;
  Vec3 centre_{0.f};
  Frame frame_;
  Vec2 half_extent_{1.f};
  float radius_ = 1;
  double area_ = 0;
};

/// Area-preserving map from the unit sphere to the unit square, and its inverse.
Vec2 square_of_direction(const Vec3& d);
Vec3 direction_of_square(const Vec2& uv);

/// Density over the unit square: half uniform, half proportional to the number of given points in
/// the cells of a grid. It is never 0, so estimates are unbiased for any points.
class ProbeGrid {
 public:
  explicit ProbeGrid(const std::vector<Vec2>& points);

  struct Sample {
    Vec2 uv;
    double pdf;  ///< per unit of area of the square
  };
  Sample sample(Random& random) const;

 private:
  static constexpr uint32_t kSide = 64;
  std::vector<float> weights_;
  GridDistribution cells_;
};

/// Parts of a receiver, each of which gets about the same number of probe rays.
class ReceiverCells {
 public:
  struct Hit {
    Vec2 uv;
    bool is_front;
  };
  /// `expected`: expected number of hits in the test. No cell has fewer than about 500 of them,
  /// unless it is the only one.
  ReceiverCells(const std::vector<Hit>& probes, double expected);
  size_t count() const { return count_; }
  size_t cell_of(const Vec2& uv, bool is_front) const;

 private:
  /// A split of the square, or a cell.
  struct Node {
    int axis = -1;  ///< -1 for a cell
    float middle = 0;
    size_t cell = 0, lower = 0, upper = 0;
  };
  size_t divide(std::vector<Vec2>& points, size_t first, size_t last, int parts, int depth);

  std::vector<Node> nodes_;
  size_t roots_[2] = {0, 0};
  size_t count_ = 0;
};

/// Estimate of the flux through the cells of a receiver.
class CellFlux {
 public:
  explicit CellFlux(size_t cells) : sums_(cells), squares_(cells) {}
  /// Adds a contribution of the current sample.
  void add(size_t cell, const Rgb& flux);
  /// Ends a sample, which may have any number of contributions.
  void end_sample();
  /// Returns the luminance of each cell, then the three channels summed over all cells. These are
  /// not independent.
  std::vector<Estimate> estimates() const;
  double total() const;
  uint64_t contributions() const { return contributions_; }

 private:
  std::vector<double> sums_, squares_;  ///< of luminance, by cell
  std::vector<std::pair<size_t, double>> current_;
  glm::dvec3 current_channels_{0.};
  Moments channels_[3];
  uint64_t samples_ = 0, contributions_ = 0;
};

}  // namespace kinome::check
