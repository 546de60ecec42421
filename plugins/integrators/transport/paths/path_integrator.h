#pragma once

#include <utility>

#include "kinome/light_groups.h"
#include "transport/path_parameters.h"
#include "transport/stages.h"

namespace kinome::transport {

/// Path tracing from the camera: the plugin `path`, also used by other integrators.
class PathIntegrator : public GroupingIntegrator {
 public:
  explicit PathIntegrator(const PathSettings& settings, LightGroups groups = {})
      : settings_(settings) {
    PathIntegrator::set_light_groups(std::move(groups));
  }

  std::vector<Stage> stages() const override {
    return {kPrimaryStage, kBounceStage, kShadeStage, kShadowStage, kFilmStage};
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override;

 private:
  PathSettings settings_;
};

}  // namespace kinome::transport
