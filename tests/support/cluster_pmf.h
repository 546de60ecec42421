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

}  // namespace kinome::test
