#pragma once

#include <string>

#include "kinome/plugin.h"
#include "kinome/point_lights.h"

/// What `clustered` and `groundtruth` have in common.
namespace kinome {

#define KINOME_POINT_LIGHT_PARAMETERS                                                              \
  {"max_depth", ParameterType::kInteger, "2",                                                      \
   "Segments of a path from the camera to a light: 2 is direct light, 3 adds one bounce."},        \
      {"mode", ParameterType::kString, "auto",                                                     \
       "Light that is made of points: 'distant' (environments), 'local' (a bounce, and emitters "  \
       "within the scene that offer points), 'both', or 'auto': all that the scene has. Without "  \
       "'local' there is no indirect light."},                                                     \
      {"light_samples", ParameterType::kInteger, "32768",                                          \
       "Points that an environment's light is made of, all of them lit; and places on surfaces "   \
       "that a 'vpl' without light_samples of its own tries, of which those that light reaches "   \
       "are its points. At least 1."},                                                             \
      {"max_geometry_term", ParameterType::kFloat, "0",                                            \
       "Bound on cos cos'/d² between surfaces [1/area], which loses light in corners; 0: none."},  \
  {                                                                                                \
    "hide_emitters", ParameterType::kBoolean, "false",                                             \
        "The camera sees no light itself: it looks through surfaces that emit, at a black sky."    \
  }

struct PointLightSettings {
  uint32_t light_samples = 0;
  PointLightOptions options;
};

inline PointLightSettings read_point_light_parameters(const Properties& props) {
  PointLightSettings settings;
  settings.light_samples = props.integer("light_samples", 1, 1 << 24);
  PointLightOptions& options = settings.options;
  options.max_depth = props.integer("max_depth", 2, 3);
  static constexpr const char* kModes[] = {"auto", "distant", "local", "both"};
  const int mode = props.choice("mode", kModes);
  options.distant = mode != 2;
  options.local = mode != 1;
  options.hide_emitters = props.boolean("hide_emitters");
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

inline ScenePointLights gather(const PointLightSettings& settings, const Scene& scene,
                               RenderContext& context) {
  const StageTimer timer(context.stats().counters.stage_seconds["light points"]);
  return gather_point_lights(scene, context, settings.light_samples, settings.options);
}

}  // namespace kinome
