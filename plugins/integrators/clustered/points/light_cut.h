#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "clustered/points/light_tree.h"
#include "clustered/points/point_selection.h"
#include "kinome/bsdf.h"

namespace kinome {

/// Distribution over the clusters of a cut: a piecewise prefix sum. ClusterImportance sets it
/// for each shading point. Belongs to one thread while it is built; const access is thread-safe.
class ClusterPmf {
 public:
  /// True if no cluster can contribute. Nothing can be sampled then.
  bool empty() const { return !(total_ > 0); }
  /// Probability of cluster c.
  float probability(uint32_t c) const;
  uint32_t size() const { return size_; }
  /// Number of lobe rays that hit the box of cluster c; 0 if none were traced.
  float hits(uint32_t c) const;

 private:
  friend class LightCut;
  static constexpr uint32_t kLanes = 16;
  /// Returns the last lane, from `first` on, that starts at or before `target` and isn't empty.
  uint32_t lane_of(float target, uint32_t first) const;
  /// Returns the last row of a lane whose probability isn't 0.
  uint32_t last_row(uint32_t lane) const;
  size_t position(uint32_t c) const { return (c % rows_) * kLanes + c / rows_; }
  uint32_t size_ = 0;
  uint32_t rows_ = 0;
  float total_ = 0;
  std::vector<float> columns_;  ///< running sums down each lane; lane l holds rows_ clusters
  std::array<float, kLanes + 1> lane_start_{};
  std::vector<float> hits_;
};

/// Unit directions, as structure of arrays.
struct LobeDirections {
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;
  size_t count = 0;
};

/// A cut through a light tree, prepared for importance functions: clusters as structure of arrays,
/// and the hierarchy of their boxes, in which hits of lobe rays are counted (4.2.2). Immutable;
/// thread-safe.
class LightCut {
 public:
  LightCut(const LightTree& tree, uint32_t size, CutCriterion criterion);
  ~LightCut();
  uint32_t size() const { return static_cast<uint32_t>(cells_.size()); }
  /// Tree cell of cluster c.
  const LightCell& cell(uint32_t c) const { return cells_[c]; }

  /// Properties of a shading point.
  struct Point {
    Vec3 normal{0, 0, 1};  ///< normal of Bsdf::reflection_frame, unit, world space
    float diffuse = 0;     ///< |kd|, luminance
    float glossy = 0;      ///< |ks|, luminance
    /// Directions of lobe samples, world space; count 0 if the BSDF has no glossy lobe.
    LobeDirections lobe = {};
    Vec3 position{0.f};  ///< world space; used only for local light
  };
  /// Factors of importances, one for each cluster (padded, in the layout of simd::ClusterColumns):
  /// summed luminance, and solid angle or area. Relative to the sum over the clusters.
  std::span<const float> luminances() const;
  std::span<const float> extents() const;

  /// Sets `pmf` to the distribution of the factor `weights` alone.
  void weigh(std::span<const float> weights, ClusterPmf& pmf) const;
  /// Sets `pmf` to the distribution of the factor `weights`, W, times light's reflection:
  ///   Gamma = W G (|kd| / pi + |ks| fs),  fs = (hits + Omega / (2 pi)) / ((Ns + 1) Omega).
  /// G is the form factor. Gamma is 0 for a cluster that can't contribute: its box is below the
  /// horizon, or (local light) all its normals face away from the point for any position in the
  /// box.
  ///
  /// Distant light: G = max(n . mean, best corner / 4). Local light (2.2, 4.2): G = cos cos' / r²
  /// for the cluster's mean; Omega = A cos' / r². Both cosines are at least a quarter of the
  /// maximum that box and cone of normals allow, and r is at least half the box's radius.
  ///
  /// Deviations from eq. 4.5: |kd| is divided by pi, as in eq. 3.3, so that both terms are BRDFs.
  /// One additional lobe sample is spread over the hemisphere, and 1/1000 of the samples over all
  /// clusters above the horizon, because an importance of 0 would lose light.
  void weigh_reflected(std::span<const float> weights, const Point& point, ClusterPmf& pmf) const;

  /// Samples a light point by each of the n numbers in [0, 1)²: a cluster by u.x (eq. 3.2), then
  /// one of its points, uniformly, by u.y (4.3.3). The thesis reuses the remainder of the first
  /// number. In single precision, that has too few bits for an improbable cluster of many points:
  /// some would never be chosen.
  ///
  /// Appends the points in the tree's order, with the weight 1 / (n probability). Points that are
  /// drawn more than once are (mostly) merged, because they need only one shadow ray. Never chooses
  /// a cluster of probability 0. Does nothing if the pmf is empty.
  void sample_points(const ClusterPmf& pmf, std::span<const Vec2> u,
                     PointSelection& selection) const;
  /// Returns the cluster that contains light point `point`.
  uint32_t cluster_of(uint32_t point) const;
  /// Returns the probability that a number selects `point`.
  float point_probability(const ClusterPmf& pmf, uint32_t point) const;

 private:
  void layout(ClusterPmf& pmf) const;
  struct Arrays;
  LightPoints::Kind kind_;
  std::vector<LightCell> cells_;
  std::unique_ptr<Arrays> arrays_;
};

}  // namespace kinome
