#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "clustered/method.h"
#include "clustered/point_light_parameters.h"
#include "clustered/points/cluster_importance.h"

namespace kinome {

struct ThesisSettings {
  MakeClusterImportance* importance = make_joint_importance;
  CutCriterion criterion = CutCriterion::kVariance;
  uint32_t cut_size = 0;         ///< number of clusters in the cut
  uint32_t emitter_samples = 0;  ///< number of light points drawn for each camera ray
  uint32_t brdf_samples = 0;     ///< number of lobe rays of each shading point
};

class ClusterChooser;

/// `clustered` as in Åkerlund 2008, for all importances except 'product', with the light points of
/// all emitters that have some.
class ThesisMethod final : public ClusteredMethod {
 public:
  /// `lacks_diagnostics`: diagnostics were requested, but only another method has them.
  ThesisMethod(const PointLightSettings& points, const ThesisSettings& settings,
               bool lacks_diagnostics)
      : points_(points), settings_(settings), lacks_diagnostics_(lacks_diagnostics) {}

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override;
  /// Returns a report for each set of light points: those chosen for the first surface behind the
  /// pixel. Throws Error if there is no surface.
  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  int x, int y) const override;

 private:
  std::deque<ClusterChooser> make_choosers(ScenePointLights& lights, const Scene& scene,
                                           const Sensor& sensor, RenderContext& context) const;
  std::shared_ptr<const LightCut> make_cut(LightPoints& points, RenderContext& context) const;
  std::shared_ptr<Sampler> lobe_sampler(const Scene& scene, const Sensor& sensor,
                                        RenderContext& context) const;

  PointLightSettings points_;
  ThesisSettings settings_;
  bool lacks_diagnostics_;
};

}  // namespace kinome
