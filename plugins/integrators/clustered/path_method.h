#pragma once

#include <utility>

#include "clustered/method.h"
#include "kinome/error.h"
#include "transport/paths/path_integrator.h"

namespace kinome {

/// Renders light groups as `path` does, if product sampling doesn't support the scene.
class PathMethod final : public ClusteredMethod {
 public:
  PathMethod(const PathSettings& settings, LightGroups groups)
      : paths_(settings, std::move(groups)) {}

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    paths_.render(scene, sensor, context);
  }
  /// Always throws: there is nothing to inspect.
  std::vector<Inspection> inspect(const Scene& scene, const Sensor& /*sensor*/,
                                  RenderContext& /*context*/, int /*x*/,
                                  int /*y*/) const override {
    throw Error(Location{scene.file()}, "cannot inspect: 'path' renders these light groups");
  }

 private:
  transport::PathIntegrator paths_;
};

}  // namespace kinome
