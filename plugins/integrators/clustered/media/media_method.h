#pragma once

#include "clustered/method.h"
#include "transport/media/volume_integrator.h"

namespace kinome {

/// Renders scenes with media. Light that uniform media scatter once toward the camera is found by
/// candidates (FogLight); all other light by path tracing, as in `volpath`. Scenes in which some
/// medium varies are rendered as by `volpath`.
class MediaMethod final : public ClusteredMethod {
 public:
  /// `has_trial`: render as by `volpath` if a trial finds that it takes less work.
  MediaMethod(const PathSettings& settings, bool has_trial);

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override;
  /// Passes share tables and the choice of the method. Returns nullptr for scenes without light.
  std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                double seconds) const override;
  /// Always throws: there is nothing to inspect.
  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  int x, int y) const override;

 private:
  PathSettings settings_;
  bool has_trial_;
  transport::VolumeIntegrator paths_;
};

}  // namespace kinome
