#pragma once

#include <functional>
#include <vector>

#include "kinome/math.h"

namespace kinome {

/// Cluster as the importance function sees it at one shading point (Åkerlund 2008, 4.3.4).
struct InspectedCluster {
  Aabb box;
  Vec3 mean{0.f};    ///< direction (distant light) or position (local light)
  Vec3 normal{0.f};  ///< local light only
  uint32_t points = 0;
  double light = 0;        ///< fraction of all light
  double brdf = 0;         ///< BRDF factor of the importance, relative to the largest
  double geometric = 0;    ///< form factor, relative to the largest
  double probability = 0;  ///< probability of sampling the cluster
  uint32_t samples = 0;    ///< number of samples in the cluster
  double hits = 0;         ///< number of lobe rays that hit its box
  double visibility = 1;   ///< learned visibility, in [0, 1]
  double sigma = 0;        ///< root mean square of its remaining uncertainty
};

/// Light point sampled at the shading point.
struct InspectedSample {
  Vec3 position{0.f};  ///< direction (distant light) or position (local light)
  double weight = 0;   ///< weight of the light point, 1 on average
  bool visible = false;
};

/// Sampling of one set of light points at one shading point.
struct Inspection {
  bool is_distant = true;  ///< true for distant light, false for local light
  Vec3 position{0.f};  ///< position of the shading point, world space
  Vec3 normal{0, 0, 1};
  std::vector<InspectedCluster> clusters;
  std::vector<InspectedSample> samples;
  bool is_learned = false;  ///< true if visibility and sigma of the clusters are learned
  /// For clusters of directions that are not boxes: returns the cluster that contains a direction.
  std::function<uint32_t(const Vec3& direction)> cluster_at;
};

}  // namespace kinome
