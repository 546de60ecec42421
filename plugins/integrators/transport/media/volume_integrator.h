#pragma once

#include "../path_integrator.h"

namespace kinome::transport {

/// Path tracing from the camera through media: the plugins `volpath` and `volpathmis`.
class VolumeIntegrator : public PathIntegrator {
 public:
  explicit VolumeIntegrator(const PathSettings& settings);

  bool traces_media() const override { return true; }
  void warn_of_light_left_out(const Scene& scene, const Sensor& sensor,
                              RenderContext& context) const override;
  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override;

 private:
  PathSettings settings_;
};

}  // namespace kinome::transport
