#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "kinome/inspection.h"
#include "kinome/integrator.h"
#include "kinome/render_context.h"

namespace kinome {

/// Records that `method` renders the image, and why: "path", "the render is short".
inline void report_method(RenderContext& context, const std::string& method,
                          const std::string& why) {
  context.job.stats().method = fmt::format("{} ({})", method, why);
}

/// Method by which the `clustered` integrator chooses light. It is prepared for one scene, which
/// must outlive it. The functions are those of Integrator.
class ClusteredMethod {
 public:
  virtual ~ClusteredMethod() = default;
  virtual void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const = 0;
  /// Returns nullptr if passes share nothing, so that each can be a separate render().
  virtual std::unique_ptr<Passes> begin(const Scene& /*scene*/, const Sensor& /*sensor*/,
                                        RenderContext& /*context*/, double /*seconds*/) const {
    return nullptr;
  }
  /// Inspects pixel (x, y).
  virtual std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor,
                                          RenderContext& context, int x, int y) const = 0;
};

}  // namespace kinome
