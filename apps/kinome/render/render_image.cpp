// Rendering an image and writing it, shared by the commands that render.

#include "render/render_image.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/clock.h"
#include "crash.h"
#include "images/denoising.h"
#include "images/image_formats.h"
#include "kinome/cryptomatte.h"
#include "kinome/image_files.h"
#include "kinome/log.h"
#include "kinome/plugin_audit.h"
#include "kinome/process_group.h"
#include "kinome/render.h"
#include "output_files/file_writer.h"
#include "say.h"
#include "signals.h"

namespace kinome::app {
namespace {

/// Number of positions at which plugins are audited: as a rule, and after non-finite samples.
constexpr uint32_t kAuditPositions = 256;
constexpr uint32_t kMaxAuditPositions = 1 << 15;

/// Exit status if the image was written but a plugin is faulty.
constexpr int kFaultyStatus = 3;

/// Returns the attributes of an image's header that describe the render.
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

/// Returns the names of the loaded integrators, separated by spaces. There are several if one (aov)
/// nests others.
std::string integrator_names(const std::vector<std::string>& plugins) {
  const std::string prefix = std::string(to_string(Category::kIntegrator)) + "/";
  std::string names;
  for (const std::string& plugin : plugins) {
    if (plugin.rfind(prefix, 0) != 0) continue;
    names += (names.empty() ? "" : " ") + plugin.substr(prefix.size());
  }
  return names;
}

}  // namespace

void set_up_log(const Options& options) {
  if (options.quiet) {
    set_log_level(LogLevel::kQuiet);
  } else {
    set_log_level(options.verbosity == 0   ? LogLevel::kWarn
                  : options.verbosity == 1 ? LogLevel::kInfo
                                           : LogLevel::kDebug);
  }
}

void set_up_render(const Options& options) {
  set_up_log(options);
  install_signal_handlers(options.quiet);
  set_image_file_threads(options.threads);
  if (!options.variant.empty()) {
    log_warn(fmt::format("-m {} is ignored: kinome has only one variant, RGB in single precision",
                         options.variant));
  }
  warn_of_missing_folders(options);
}

LoadOptions load_options(const Options& options) {
  return {.defines = options.defines,
          .search_paths = options.search_paths,
          .threads = options.threads,
          .lenient = options.lenient};
}

InstructionSet used_instruction_set(const PluginRegistry& registry) {
  InstructionSet best = min_instruction_set();
  for (const Category category : kCategories) {
    const std::string prefix = std::string(to_string(category)) + "/";
    for (const std::string& name : registry.loaded()) {
      if (!name.starts_with(prefix)) continue;
      for (const auto set : registry.instruction_sets(category, name.substr(prefix.size()))) {
        if (set <= registry.instruction_set()) best = std::max(best, set);
      }
    }
  }
  return best;
}

void warn_of_unused_instruction_set(const Options& options, const PluginRegistry& registry) {
  const char* const variable = std::getenv("KINOME_ISA");
  if (options.isa.empty() && (!variable || !*variable)) return;
  const InstructionSet used = used_instruction_set(registry);
  if (used == registry.instruction_set()) return;
  log_warn(fmt::format("{} {}: no plugin of this scene is built for it; using those for {}",
                       options.isa.empty() ? "KINOME_ISA" : "--isa",
                       to_string(registry.instruction_set()), to_string(used)));
}

void warn_of_layers(const Scene& scene, const Film& film, const Output& output) {
  if (scene.integrator().channels().empty()) return;
  const std::string given = lower_extension(output.image);
  const std::string extension = given.empty() ? film.file_extension() : given;
  if (stores_channels(extension, &film)) return;
  log_warn(fmt::format("{} files store only colour: the integrator's other channels are left out",
                       extension));
}

Image render_image(const Options& options, const Scene& scene, const Sensor& sensor,
                   RenderContext& context, Display* display, const PartRender* part) {
  const Film& film = sensor.film();
  PassCallback on_pass;
  if (display) {
    context.scheduler.set_commit_callback(
        [display](const Film& shown, const Rect& pixels) { display->show(shown, pixels); });
    on_pass = [display](const Image& image, const RenderStats&) { display->show(image); };
  }
  const ProcessGroup* const group = context.job.group();
  set_activity("rendering");
  log_info(fmt::format("rendering {}x{} pixels of {} on {} threads{}", film.crop().width(),
                       film.crop().height(), options.scene, context.scheduler.threads(),
                       group ? fmt::format(" of each of {} processes", group->size()) : ""));
  Image image = part                ? part->render(context)
                : options.parts > 0 ? render_all_parts(scene, sensor, context, options.parts)
                                    : render(scene, sensor, context, on_pass);
  if (display) display->show(image);
  return image;
}

ImageMetadata describe_image(const Options& options, const Scene& scene, RenderContext& context,
                             const PluginRegistry& registry, const PartRender* part) {
  RenderStats& stats = context.job.stats();
  stats.plugins = registry.loaded();
  stats.instruction_set = to_string(used_instruction_set(registry));
  ImageMetadata metadata =
      metadata_of(scene, context.job, integrator_names(stats.plugins), stats);
  if (options.parts > 0 && !part) metadata.merge(metadata_of_parts(options.parts));
  std::vector<std::string> channels;
  for (const FilmChannel& channel : scene.integrator().channels()) {
    channels.push_back(options.denoise ? scene_channel(channel.name) : channel.name);
  }
  metadata.merge(cryptomatte_metadata(scene, channels));
  if (options.denoise && !part) {
    metadata["kinome:denoised"] = options.denoise_as_layer ? "layer" : "image";
  }
  return metadata;
}

void audit_render(const Scene& scene, const Sensor& sensor, RenderContext& context) {
  RenderStats& stats = context.job.stats();
  set_activity("checking plugins");
  stats.faults = audit_plugins(scene, sensor, context.job.seed(),
                               stats.non_finite_samples > 0 ? kMaxAuditPositions : kAuditPositions,
                               &context.scheduler);
}

RenderSummary summary_of(const Options& options, const Sensor& sensor, RenderContext& context,
                         const Image& image, const Output& output) {
  const Film& film = sensor.film();
  const RenderStats& stats = context.job.stats();
  return {.scene = options.scene,
          .output = output.name(),
          .integrator = integrator_names(stats.plugins),
          .width = image.width,
          .height = image.height,
          .x = film.crop().x0,
          .y = film.crop().y0,
          .full_width = film.width(),
          .full_height = film.height(),
          .samples = static_cast<unsigned>(std::lround(stats.samples)),
          .seed = context.job.seed()};
}

RenderSummary finish_image(const Options& options, const Scene& scene, const Sensor& sensor,
                           RenderContext& context, const PluginRegistry& registry,
                           const Image& image, const Output& output, Checkpoint* checkpoint,
                           const PartRender* part, const DenoisingSetup* setup) {
  RenderStats& stats = context.job.stats();
  const Clock::time_point write_start = Clock::now();
  set_activity("writing the image");
  ImageMetadata metadata = describe_image(options, scene, context, registry, part);
  if (setup && part) add_filter(*setup, sensor.film(), metadata);
  write_image_files(options, sensor.film(), image, metadata, output, checkpoint, part);
  if (checkpoint && stats.complete) remove_checkpoint(*checkpoint, output);
  stats.write_seconds = seconds_since(write_start);
  audit_render(scene, sensor, context);
  return summary_of(options, sensor, context, image, output);
}

void report_faults(const Options& options, const RenderStats& stats) {
  // The reason for exit status 3 is reported even with --quiet.
  if (options.quiet && exit_status(options, stats) == kFaultyStatus) {
    set_log_level(LogLevel::kWarn);
  }
  if (stats.non_finite_samples > 0) {
    log_warn(fmt::format("dropped samples that were not finite: {}", stats.non_finite_samples));
  }
  for (const PluginFault& fault : stats.faults) {
    log_warn(fmt::format("plugin {} is at fault: {}, at {} of {} positions", fault.plugin,
                         fault.what, fault.count, fault.looks));
  }
}

void print_statistics(const Options& options, const RenderStats& stats,
                      const RenderSummary& summary) {
  if (options.stats == StatsFormat::kText) {
    say("{}", stats_text(stats, summary));
  } else if (options.stats == StatsFormat::kJson) {
    fmt::print("{}", stats_json(stats, summary));
    std::fflush(stdout);  // a failure is reported at the end
  }
}

int exit_status(const Options& options, const RenderStats& stats) {
  const bool is_faulty = stats.non_finite_samples > 0 || !stats.faults.empty();
  // In a group, the signal may have arrived in another process.
  const int signal_status =
      stats.complete || signal_exit_status() != 0 ? signal_exit_status() : 128 + SIGINT;
  return signal_status == 0 && is_faulty && !options.lenient ? kFaultyStatus : signal_status;
}

}  // namespace kinome::app
