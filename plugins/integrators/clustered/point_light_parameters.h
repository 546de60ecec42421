#pragma once

#include <string>

#include "clustered/light_left_out.h"
#include "clustered/points/point_lights.h"
#include "kinome/plugin.h"
#include "transport/paths/path_integrator.h"

/// Parameters and functions that `clustered` and `groundtruth` share.
namespace kinome {

inline constexpr const char* kModes[] = {"auto", "distant", "local", "both"};

#define KINOME_POINT_LIGHT_PARAMETERS                                                             \
  {"max_depth", ParameterType::kInteger, "-1",                                                    \
   "Maximum edges of a path: 1 is emission alone, 2 direct light, 3 one bounce; -1: no limit. "   \
   "With light points ('groundtruth', and 'clustered' unless importance is 'product'), longer "   \
   "paths than 3 are left out; a warning estimates their light."},                                \
      choice_of("mode", kModes, "auto",                                                           \
                "Light that is represented by light points: 'distant' (environments), 'local' "   \
                "(one bounce, and emitters in the scene that have light points), 'both', or "     \
                "'auto': all of the scene's. Without 'local' there is no indirect light."),       \
      {"light_samples", ParameterType::kInteger, "32768",                                         \
       "Number of light points of an environment. Also the number of positions on surfaces that " \
       "a 'vpl' without light_samples samples; those that light reaches become light points. "    \
       "At least 1."},                                                                            \
      {"max_geometry_term", ParameterType::kFloat, "0",                                           \
       "Limit of cos cos'/d² between surfaces [1/area]; loses light in corners. 0: no limit."},   \
  {                                                                                               \
    "hide_emitters", ParameterType::kBoolean, "false",                                            \
        "The camera doesn't see emitters: it looks through surfaces that emit, and the sky is "   \
        "black, also behind masks and panes."                                                     \
  }

/// Maximum number of edges of paths over light points.
inline constexpr uint32_t kMaxPathEdges = 3;

struct PointLightSettings {
  uint32_t light_samples = 0;
  PointLightOptions options;  ///< max_depth is at most kMaxPathEdges
  PathSettings requested;     ///< paths requested by max_depth
  Location where;             ///< location of the integrator in the scene file
};

inline PointLightSettings read_point_light_parameters(const Properties& props) {
  PointLightSettings settings;
  settings.light_samples = props.integer("light_samples", 1, 1 << 24);
  PointLightOptions& options = settings.options;
  const int mode = props.choice("mode");
  options.distant = mode != 2;
  options.local = mode != 1;
  options.hide_emitters = props.boolean("hide_emitters");
  settings.where = props.where();
  settings.requested.length.max_depth = read_max_depth(props);
  settings.requested.hide_emitters = options.hide_emitters;
  options.max_depth = std::min(settings.requested.length.max_depth, kMaxPathEdges);
  options.max_geometry_term = props.real("max_geometry_term");
  if (!(options.max_geometry_term >= 0)) {
    throw props.error("max_geometry_term",
                      "must not be negative, got " + format_number(options.max_geometry_term));
  }
  return settings;
}

/// Returns the default for Integrator::default_indirect_emitter().
inline const char* indirect_emitter(const PointLightSettings& settings) {
  return settings.options.max_depth >= 3 && settings.options.local ? "vpl" : nullptr;
}

/// Renders paths of max_depth 0 or 1 as `path` does, because no light is chosen for them. Returns
/// true if it has rendered.
inline bool render_without_surfaces(const PointLightSettings& settings, const Scene& scene,
                                    const Sensor& sensor, RenderContext& context) {
  if (settings.options.max_depth >= 2) return false;
  transport::PathIntegrator(settings.requested).render(scene, sensor, context);
  return true;
}

/// Implements Integrator::warn_of_ignored_light. Warns only if longer paths are requested than
/// kMaxPathEdges.
inline void warn_of_ignored_light(const PointLightSettings& settings, const Scene& scene,
                                  const Sensor& sensor, RenderContext& context) {
  if (settings.requested.length.max_depth <= kMaxPathEdges) return;
  const uint32_t longest = settings.options.local ? kMaxPathEdges : 2;
  warn_of_ignored_light(settings.where, settings.requested, longest, scene, sensor, context);
}

inline ScenePointLights gather(const PointLightSettings& settings, const Scene& scene,
                               RenderContext& context) {
  const StageTimer timer(context.job.stats().counters.stage_seconds["light points"]);
  return gather_point_lights(scene, context, settings.light_samples, settings.options);
}

}  // namespace kinome
