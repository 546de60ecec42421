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

/// What the importance of a cluster is made of (Åkerlund 2008, 3.1).
enum class Importance { kJoint, kLuminance, kBrdf };

/// Distribution over the clusters of a cut: a piecewise prefix sum, made anew for each shading
/// point by LightCut::build. Belongs to one thread while it is built; const access is thread-safe.
class ClusterPmf {
 public:
  struct Choice {
    uint32_t cluster = 0;
    float probability = 0;  ///< exactly that of sample()
  };
  /// True where no cluster can contribute: nothing is sampled then.
  bool empty() const { return !(total_ > 0); }
  /// A cluster for u in [0, 1). The pmf must not be empty. Never a cluster of probability 0.
  Choice sample(float u) const;
  /// Probability of cluster c.
  float probability(uint32_t c) const;
  uint32_t size() const { return size_; }
  /// Lobe rays that met cluster c's box (0 where none were sent).
  float hits(uint32_t c) const;

 private:
  friend class LightCut;
  static constexpr uint32_t kLanes = 16;
  /// The last lane that starts at or before `target` and isn't empty; from `first` on.
  uint32_t lane_of(float target, uint32_t first) const;
  /// The last row of a lane whose probability isn't 0.
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

/// A cut through a light tree, ready for importance functions: clusters as structure of arrays, and
/// the boxes' hierarchy that lobe rays are counted against (4.2.2). Immutable; thread-safe.
class LightCut {
 public:
  LightCut(const LightTree& tree, uint32_t size, CutCriterion criterion);
  ~LightCut();
  uint32_t size() const { return static_cast<uint32_t>(cells_.size()); }
  /// The cell of cluster c.
  const LightCell& cell(uint32_t c) const { return cells_[c]; }

  /// What a shading point knows.
  struct Point {
    Vec3 normal{0, 0, 1};  ///< of reflection (Bsdf::reflection_frame), unit, world space
    float diffuse = 0;     ///< |kd|, luminance
    float glossy = 0;      ///< |ks|
    /// Directions of lobe samples, world space; count 0 where the BSDF has no glossy lobe.
    LobeDirections lobe;
    Vec3 position{0.f};  ///< world space; matters to local light only
  };
  /// The distribution of eq. 3.1 for kJoint or kBrdf:
  ///   Gamma = W G (|kd| / pi + |ks| fs),  fs = (hits + Omega / (2 pi)) / ((Ns + 1) Omega),
  /// W the cluster's summed luminance (kJoint) or its solid angle or area (kBrdf), G the form
  /// factor, and 0 for a cluster that can't contribute: its box lies below the horizon, or (local)
  /// all its normals face away, whatever the place in the box.
  /// Distant: G = max(n . mean, best corner / 4). Local (2.2, 4.2): G = cos cos' / r² for the
  /// cluster's average, both cosines at least a quarter of the best that box and cone of normals
  /// allow, r at least half the box's radius; Omega = A cos' / r².
  /// Deviations from eq. 4.5, each for a reason: |kd| is divided by pi, as eq. 3.3 does, so that
  /// both terms are BRDFs; one more lobe sample is spread over the hemisphere, and 1/1000 of the
  /// samples over all clusters above the horizon, since an importance of 0 where light is not 0
  /// would lose that light.
  void build(Importance importance, const Point& point, ClusterPmf& pmf) const;
  /// The distribution of luminance alone (3.1.1): the same for every point.
  ClusterPmf luminance_pmf() const;

  struct PointChoice {
    uint32_t point = 0;     ///< index into the tree's points
    float probability = 0;  ///< exactly that of sample_point()
  };
  /// A light point: a cluster by u.x (eq. 3.2), then any of its points alike by u.y (4.3.3). The
  /// thesis reuses what the first number leaves over; in single precision that has too few bits for
  /// an improbable cluster of many points, and some of them would never be chosen. The pmf must not
  /// be empty.
  PointChoice sample_point(const ClusterPmf& pmf, const Vec2& u) const;
  /// sample_point for all of `u`, each counting 1 / (n probability): a selection in the tree's
  /// order, in which points that were drawn more than once are (mostly) merged, as they need but
  /// one shadow ray. Several times faster than one by one. Does nothing where the pmf is empty.
  void sample_points(const ClusterPmf& pmf, std::span<const Vec2> u,
                     PointSelection& selection) const;
  /// The cluster that light point `point` is in.
  uint32_t cluster_of(uint32_t point) const;
  /// Probability that sample_point() chooses `point`.
  float point_probability(const ClusterPmf& pmf, uint32_t point) const;

 private:
  void layout(ClusterPmf& pmf) const;
  struct Arrays;
  LightPoints::Kind kind_;
  std::vector<LightCell> cells_;
  std::unique_ptr<Arrays> arrays_;
};

}  // namespace kinome
