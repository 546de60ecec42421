#pragma once

#include "kinome/integrator.h"
#include "path_parameters.h"
#include "stages.h"

namespace kinome::transport {

/// Path tracing from the camera: the plugin `path`, also used by other integrators.
class PathIntegrator : public Integrator {
 public:
  explicit PathIntegrator(const PathSettings& settings) : settings_(settings) {}

  std::vector<Stage> stages() const override {
    return {kPrimaryStage, kBounceStage, kShadeStage, kShadowStage, kFilmStage};
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override;

 private:
  PathSettings settings_;
};

}  // namespace kinome::transport
