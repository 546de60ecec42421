#pragma once

#include "clustered/points/cluster_importance.h"

namespace kinome::test {

/// Returns the distribution over the clusters of `cut` for a shading point.
inline ClusterPmf pmf_of(MakeClusterImportance* make_importance, const LightCut& cut,
                         const LightCut::Point& point = {}) {
  const std::unique_ptr<ClusterImportance> importance = make_importance();
  importance->prepare(cut);
  ClusterPmf pmf;
  return importance->weigh(point, pmf);
}

struct DrawnPoint {
  uint32_t point;
  uint32_t cluster;
  float weight;
};
/// Returns the light point that a single number selects. The distribution must not be empty.
inline DrawnPoint draw_one(const LightCut& cut, const ClusterPmf& pmf, const Vec2& u) {
  PointSelection selection;
  cut.sample_points(pmf, {&u, 1}, selection);
  const uint32_t point = selection.points.at(0);
  return {point, cut.cluster_of(point), selection.weights.at(0)};
}

/// Returns the weight of draw_one() for the points of a cluster.
inline float weight_of(const LightCut& cut, const ClusterPmf& pmf, uint32_t cluster) {
  return static_cast<float>(cut.cell(cluster).count) / pmf.probability(cluster);
}

}  // namespace kinome::test
