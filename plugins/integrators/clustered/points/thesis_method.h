#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "clustered/points/cluster_importance.h"
#include "clustered/points/point_lights.h"
#include "kinome/inspection.h"

namespace kinome {

struct ThesisSettings {
  MakeClusterImportance* importance = make_joint_importance;
  CutCriterion criterion = CutCriterion::kVariance;
  uint32_t cut_size = 0;         ///< number of clusters in the cut
  uint32_t emitter_samples = 0;  ///< number of light points drawn for each camera ray
  uint32_t brdf_samples = 0;     ///< number of lobe rays of each shading point
  PointLightOptions options;
};

class ClusterChooser;

/// `clustered` as in Åkerlund 2008, for all importances except 'product'.
class ThesisMethod {
 public:
  explicit ThesisMethod(const ThesisSettings& settings) : settings_(settings) {}

  void render(ScenePointLights lights, const Scene& scene, const Sensor& sensor,
              RenderContext& context) const;
  /// Returns a report for each set of light points: those chosen for the first surface behind pixel
  /// (x, y). Throws Error if there is no surface.
  std::vector<Inspection> inspect(ScenePointLights lights, const Scene& scene, const Sensor& sensor,
                                  RenderContext& context, int x, int y) const;

 private:
  std::deque<ClusterChooser> make_choosers(ScenePointLights& lights, const Scene& scene,
                                           const Sensor& sensor, RenderContext& context) const;
  std::shared_ptr<const LightCut> make_cut(LightPoints& points, RenderContext& context) const;
  std::shared_ptr<Sampler> lobe_sampler(const Scene& scene, const Sensor& sensor,
                                        RenderContext& context) const;

  ThesisSettings settings_;
};

}  // namespace kinome
