#pragma once

#include <string>

#include "clustered/light_left_out.h"
#include "clustered/points/point_lights.h"
#include "kinome/plugin.h"
#include "transport/render_paths.h"

/// What `clustered` and `groundtruth` have in common.
namespace kinome {

inline constexpr const char* kModes[] = {"auto", "distant", "local", "both"};

#define KINOME_POINT_LIGHT_PARAMETERS                                                             \
  {"max_depth", ParameterType::kInteger, "-1",                                                    \
   "Longest path, in edges: 1 is emission alone, 2 direct light, 3 one bounce; -1: no limit. "    \
   "Of light points ('groundtruth', and 'clustered' unless importance is 'product'), 3 is the "   \
   "most: a warning tells how much light is left out beyond."},                                   \
      choice_of("mode", kModes, "auto",                                                           \
                "Light that is made of points: 'distant' (environments), 'local' (a bounce, and " \
                "emitters within the scene that offer points), 'both', or 'auto': all that the "  \
                "scene has. Without 'local' there is no indirect light."),                        \
      {"light_samples", ParameterType::kInteger, "32768",                                         \
       "Points that an environment's light is made of, all of them lit; and places on surfaces "  \
       "that a 'vpl' without light_samples of its own tries, of which those that light reaches "  \
       "are its points. At least 1."},                                                            \
      {"max_geometry_term", ParameterType::kFloat, "0",                                           \
       "Bound on cos cos'/d² between surfaces [1/area], which loses light in corners; 0: none."}, \
  {                                                                                               \
    "hide_emitters", ParameterType::kBoolean, "false",                                            \
        "The camera doesn't see emitters: it looks through surfaces that emit, and the sky is "   \
        "black, also behind masks and panes."                                                     \
  }

/// Of the paths that are rendered, in edges.
inline constexpr uint32_t kLongestPath = 3;

struct PointLightSettings {
  uint32_t light_samples = 0;
  PointLightOptions options;  ///< of max_depth, what is rendered
  PathSettings asked;         ///< the paths that max_depth asks for
  Location where;             ///< of the integrator in the scene file
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
  settings.asked.length.max_depth = read_max_depth(props);
  settings.asked.hide_emitters = options.hide_emitters;
  options.max_depth = std::min(settings.asked.length.max_depth, kLongestPath);
  options.max_geometry_term = props.real("max_geometry_term");
  if (!(options.max_geometry_term >= 0)) {
    throw props.error("max_geometry_term",
                      "must not be negative, got " + std::to_string(options.max_geometry_term));
  }
  return settings;
}

/// What a scene without indirect emitters gets.
inline const char* indirect_emitter(const PointLightSettings& settings) {
  return settings.options.max_depth >= 3 && settings.options.local ? "vpl" : nullptr;
}

/// Paths of max_depth 0 and 1 come to no surface that light is to be chosen for: true where that is
/// all that is asked for, and it is rendered, as `path` does it.
inline bool render_without_surfaces(const PointLightSettings& settings, const Scene& scene,
                                    const Sensor& sensor, RenderContext& context) {
  if (settings.options.max_depth >= 2) return false;
  transport::render_paths(settings.asked, scene, sensor, context);
  return true;
}

/// Integrator::warn_of_light_left_out, where more is asked for than this integrator renders at
/// best.
inline void warn_of_light_left_out(const PointLightSettings& settings, const Scene& scene,
                                   const Sensor& sensor, RenderContext& context) {
  if (settings.asked.length.max_depth <= kLongestPath) return;
  const uint32_t longest = settings.options.local ? kLongestPath : 2;
  warn_of_light_left_out(settings.where, settings.asked, longest, scene, sensor, context);
}

inline ScenePointLights gather(const PointLightSettings& settings, const Scene& scene,
                               RenderContext& context) {
  const StageTimer timer(context.stats().counters.stage_seconds["light points"]);
  return gather_point_lights(scene, context, settings.light_samples, settings.options);
}

}  // namespace kinome
