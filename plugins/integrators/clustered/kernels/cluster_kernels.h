#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kinome/columns.h"

/// Kernels over the clusters of a cut. Layouts are kBlockLanes wide for all instruction sets, so
/// that the order of sums is the same everywhere.
namespace kinome::simd {

inline constexpr size_t kFanOut = kBlockLanes;

/// Clusters as structure of arrays of `rows` x kBlockLanes values. Cluster c is in lane c / rows
/// and row c % rows, at position row * kBlockLanes + lane. A lane holds consecutive clusters, so
/// that a running sum down its rows is a prefix sum. Padding has weight 0.
struct ClusterColumns {
  size_t rows = 0;
  const float* mean[3];
  const float* lo[3];
  const float* hi[3];
  const float* weight;  ///< factor of the importance: light, or extent
  const float* inverse_extent;
};

/// Additional columns of local clusters, in the same layout.
struct LocalColumns {
  const float* half[3];    ///< half size of the box around the mean that holds the cluster's box
  const float* normal[3];  ///< axis of the cone of the points' normals; 0 if they cancel
  const float* cone_sine;  ///< sine of the cone's half angle; 1 from a right angle on
  const float* inverse_one_plus_sine;
  /// Maximum additional distance, over that of the mean, of a point of the box along a normal of
  /// the cone: |normal| . half + sine |half|.
  const float* reach;
  const float* min_distance2;  ///< minimum of squared distances; positive
};

struct ImportanceQuery {
  float normal[3];
  float diffuse = 0;            ///< |kd| / pi
  float glossy_hit = 0;         ///< |ks| / (Ns + 1): importance per hit and inverse extent
  float glossy_floor = 0;       ///< |ks| / (2 pi (Ns + 1))
  const float* hits = nullptr;  ///< in the layout of ClusterColumns; nullptr if there are none
  float position[3] = {};       ///< position of the shading point; local clusters only
  float unit_area = 1;          ///< unit of areas, so that form factors have no unit; local only
};

/// Share of the samples that is distributed uniformly over the clusters that can contribute. No
/// probability is then so small that a running sum in float would lose it.
inline constexpr float kEvenShare = 1e-3f;

/// Computes the importance of each cluster, as running sums down each lane in `columns` (rows x
/// kBlockLanes), with the sum of each lane in `lane_sums` (kBlockLanes). Returns the total; 0 if no
/// cluster can contribute.
float cluster_importance(const ClusterColumns& clusters, const ImportanceQuery& query,
                         float* columns, float* lane_sums);
/// The same for local light: form factors with both cosines and the squared distance.
float local_cluster_importance(const ClusterColumns& clusters, const LocalColumns& local,
                               const ImportanceQuery& query, float* columns, float* lane_sums);

/// Tree of boxes with fan-out kFanOut. Level 0 has the boxes themselves. kFanOut consecutive boxes
/// form a group and have one parent in the next level; the last level is one group. A group has
/// 6 x kFanOut floats: for each axis the lower, then the upper bounds. Padding boxes are inverted
/// (lo > hi) and never hit.
struct BoxTree {
  std::vector<float> groups;
  std::vector<uint32_t> level_start;  ///< first group of each level
};

/// Segments origin + t d, t_min <= t <= t_max, of `count` directions.
struct LobeRays {
  float origin[3];
  float t_min;
  float t_max;
  const float* dx;
  const float* dy;
  const float* dz;
  size_t count;
};

/// Adds 1 to hits[position[c]] for each segment and each box c of level 0 that it intersects (slab
/// test of Williams et al. 2005).
void count_box_hits(const BoxTree& tree, const LobeRays& rays, const uint32_t* position,
                    float* hits);

}  // namespace kinome::simd
