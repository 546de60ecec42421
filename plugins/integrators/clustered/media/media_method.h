#pragma once

#include "clustered/method.h"
#include "transport/media/paths/volume_integrator.h"

namespace kinome {

/// Renders scenes with media. Candidates (FogLight) find the light that uniform media scatter once
/// toward the camera. Path tracing, as in `volpath`, finds all other light, and renders scenes in
/// which some medium varies.
class MediaMethod final : public ClusteredMethod {
 public:
  /// With `has_trial`, renders as `volpath` does if a trial finds that this takes less work. With
  /// light groups, always does.
  MediaMethod(const PathSettings& settings, bool has_trial, LightGroups groups = {});

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override;
  /// Passes share tables and the choice of the method. Returns nullptr for scenes without light.
  std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                double seconds) const override;
  /// Always throws Error, because there are no clusters to inspect.
  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  int x, int y) const override;

 private:
  const char* why_paths(const Scene& scene, const Sensor& sensor) const;

  PathSettings settings_;
  bool has_trial_;
  bool has_groups_;
  transport::VolumeIntegrator paths_;
};

}  // namespace kinome
