#include "render/metadata.h"

#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kinome::app {

std::string part_text(const Options& options) {
  if (options.parts == 0) return "";
  return (options.part == 0 ? "all" : std::to_string(options.part)) + "/" +
         std::to_string(options.parts);
}

Checkpoint::Identity identity_of(const Options& options, const Scene& scene, const Sensor& sensor,
                                 InstructionSet instruction_set) {
  size_t index = 0;
  while (scene.sensors()[index].get() != &sensor) ++index;
  const Rect& crop = sensor.film().crop();
  return {{"version", KINOME_VERSION},
          {Checkpoint::kScene, scene.hash()},
          {"sensor", std::to_string(index)},
          {"image size", fmt::format("{}x{}", crop.width(), crop.height())},
          {"seed", std::to_string(options.seed)},
          {"--variance", std::to_string(options.renders)},
          {"--error", fmt::format("{}", options.rel_mse)},
          {"--part", part_text(options)},
          {"--isa", to_string(instruction_set)}};
}

ImageMetadata metadata_of(const Scene& scene, const RenderJob& job, const std::string& integrator,
                          const RenderStats& stats) {
  ImageMetadata metadata = {
      {"kinome:version", KINOME_VERSION},
      {"kinome:scene", scene.file()},
      {"kinome:scene_hash", scene.hash()},
      {"kinome:integrator", integrator},
      {"kinome:samples", std::to_string(std::lround(stats.samples))},
      {"kinome:seed", std::to_string(job.seed())},
      {"kinome:isa", stats.instruction_set},
      {"kinome:plugins", fmt::format("{}", fmt::join(stats.plugins, " "))},
      {"kinome:complete", stats.complete ? "true" : "false"},
  };
  if (!stats.left_out.empty()) {
    metadata["kinome:left_out"] = fmt::format("{}", fmt::join(stats.left_out, "; "));
  }
  if (!stats.complete) {
    metadata["kinome:filled"] = fmt::format("{:.4g}", stats.filled);
    metadata["kinome:missing"] = fmt::format("{:.4g}", stats.missing);
  }
  if (stats.rel_mse >= 0) metadata["kinome:relmse"] = fmt::format("{:.4g}", stats.rel_mse);
  if (stats.renders > 0) {
    metadata["kinome:renders"] = std::to_string(stats.renders);
    metadata["kinome:variance_of_mean"] =
        fmt::format("{:.9g}", fmt::join(stats.variance_of_mean, " "));
  }
  return metadata;
}

std::string integrator_names(const std::vector<std::string>& plugins) {
  const std::string prefix = std::string(to_string(Category::kIntegrator)) + "/";
  std::string names;
  for (const std::string& plugin : plugins) {
    if (plugin.rfind(prefix, 0) != 0) continue;
    names += (names.empty() ? "" : " ") + plugin.substr(prefix.size());
  }
  return names;
}

}  // namespace kinome::app
