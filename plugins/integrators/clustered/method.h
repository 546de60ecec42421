#pragma once

#include <memory>
#include <vector>

#include "kinome/inspection.h"
#include "kinome/integrator.h"

namespace kinome {

/// A way to choose the light that rays ask for, prepared for one scene, which must outlive it: what
/// the `clustered` integrator renders with. Functions are those of Integrator.
class ClusteredMethod {
 public:
  virtual ~ClusteredMethod() = default;
  virtual void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const = 0;
  /// nullptr: passes have nothing in common, and each is a render() of its own.
  virtual std::unique_ptr<Passes> begin(const Scene& /*scene*/, const Sensor& /*sensor*/,
                                        RenderContext& /*context*/, double /*seconds*/) const {
    return nullptr;
  }
  /// Of pixel (x, y).
  virtual std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor,
                                          RenderContext& context, int x, int y) const = 0;
};

}  // namespace kinome
