#pragma once

#include <functional>
#include <vector>

#include "kinome/light_points.h"

namespace kinome {

/// A cluster as the importance function saw it at one shading point (Åkerlund 2008, 4.3.4).
struct InspectedCluster {
  Aabb box;
  Vec3 mean{0.f};    ///< direction (distant light) or position
  Vec3 normal{0.f};  ///< of local light
  uint32_t points = 0;
  double light = 0;        ///< share of all light
  double brdf = 0;         ///< BRDF part of the importance; the largest is 1
  double geometric = 0;    ///< form factor; the largest is 1
  double probability = 0;  ///< of the cluster
  uint32_t samples = 0;    ///< how often it was chosen
  double hits = 0;         ///< lobe rays that met its box
  double visibility = 1;   ///< as learned, in [0, 1]
  double sigma = 0;        ///< root mean square of what is left uncertain of it
};

struct InspectedSample {
  Vec3 position{0.f};  ///< direction (distant light) or position
  double weight = 0;   ///< times that the light point counts, on average 1
  bool visible = false;
};

/// Where the samples of one shading point go, for one set of light points.
struct Inspection {
  LightPoints::Kind kind = LightPoints::Kind::kDistant;
  Vec3 position{0.f};  ///< of the shading point
  Vec3 normal{0, 0, 1};
  std::vector<InspectedCluster> clusters;
  std::vector<InspectedSample> samples;
  bool is_learned = false;  ///< visibility and sigma of clusters were learned
  /// Of clusters of directions that are no boxes: the one that a direction lies in.
  std::function<uint32_t(const Vec3& direction)> cluster_at;
};

}  // namespace kinome
