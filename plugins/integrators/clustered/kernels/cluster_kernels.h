#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kinome/columns.h"

/// Kernels over the clusters of a cut. Layouts are fixed, kBlockLanes wide, whatever the machine's
/// vectors are: sums are taken in the same order everywhere.
namespace kinome::simd {

inline constexpr size_t kFanOut = kBlockLanes;

/// Clusters as structure of arrays, all `rows` x kBlockLanes values: cluster c lies in lane c /
/// rows, row c % rows, at position row * kBlockLanes + lane, so that one lane holds consecutive
/// clusters and a running sum down the rows is a prefix sum. Padding has weight 0.
struct ClusterColumns {
  size_t rows = 0;
  const float* mean[3];
  const float* lo[3];
  const float* hi[3];
  const float* weight;  ///< what multiplies the BRDF's part: light, or extent
  const float* inverse_extent;
};

/// What local clusters have besides, in the same layout.
struct LocalColumns {
  const float* half[3];    ///< of the smallest box around the mean that holds the cluster's box
  const float* normal[3];  ///< axis of the cone of the points' normals; 0 where it can't be had
  const float* cone_sine;  ///< of the cone's half angle; 1 from a right angle on
  const float* inverse_one_plus_sine;
  /// How much farther than the mean any point of the box may lie behind any normal of the cone:
  /// |normal| . half + sine |half|.
  const float* reach;
  const float* least_distance2;  ///< squared distances count as no less; positive
};

struct ImportanceQuery {
  float normal[3];
  float diffuse = 0;            ///< |kd| / pi
  float glossy_hit = 0;         ///< |ks| / (Ns + 1): importance per hit and inverse extent
  float glossy_floor = 0;       ///< |ks| / (2 pi (Ns + 1))
  const float* hits = nullptr;  ///< in the layout of ClusterColumns; nullptr: none
  float position[3] = {};       ///< of the shading point; local clusters only
  float unit_area = 1;          ///< local clusters only: keeps form factors without a unit
};

/// Share of the samples that is spread evenly over the clusters that can contribute: no pmf is so
/// small that a running sum in float would lose it.
inline constexpr float kEvenShare = 1e-3f;

/// Importance of each cluster, as running sums down each lane in `columns` (rows x kBlockLanes),
/// with the sum of each lane in `lane_sums` (kBlockLanes). Returns the total; 0 where no cluster
/// can contribute.
float cluster_importance(const ClusterColumns& clusters, const ImportanceQuery& query,
                         float* columns, float* lane_sums);
/// The same for local light: form factors with both cosines and the squared distance.
float local_cluster_importance(const ClusterColumns& clusters, const LocalColumns& local,
                               const ImportanceQuery& query, float* columns, float* lane_sums);

/// Boxes under a tree of fan-out kFanOut, level 0 being the boxes themselves: kFanOut consecutive
/// boxes form a group and have one parent in the next level; the last level is one group. A group
/// is 6 x kFanOut floats: for each axis the lower, then the upper bounds. Padding boxes are
/// inverted (lo > hi) and never hit.
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

/// Adds 1 to hits[position[c]] for each box c of level 0 that each segment meets (slab test of
/// Williams et al. 2005).
void count_box_hits(const BoxTree& tree, const LobeRays& rays, const uint32_t* position,
                    float* hits);

}  // namespace kinome::simd
