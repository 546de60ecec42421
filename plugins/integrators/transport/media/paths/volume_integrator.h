#pragma once

#include "transport/paths/path_integrator.h"

namespace kinome::transport {

struct VolumeTables;

/// Path tracing from the camera through media: the plugins `volpath` and `volpathmis`.
class VolumeIntegrator : public PathIntegrator {
 public:
  explicit VolumeIntegrator(const PathSettings& settings);

  bool traces_media() const override { return true; }
  void warn_of_ignored_light(const Scene& scene, const Sensor& sensor,
                             RenderContext& context) const override;
  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override;
  /// All passes share the tables of media, which bound the extinction of grids.
  std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                double seconds) const override;

 private:
  bool has_volume_paths(const Scene& scene, const VolumeTables& tables) const;
  PathSettings settings_;
};

}  // namespace kinome::transport
