// Renders a scene file, or looks for its faults: from options to files and an exit status.

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "base/clock.h"
#include "commands.h"
#include "crash.h"
#include "inspect.h"
#include "kinome/checkpoint.h"
#include "kinome/log.h"
#include "kinome/plugin_audit.h"
#include "kinome/render.h"
#include "kinome/scene_loader.h"
#include "metadata.h"
#include "output.h"
#include "progress.h"
#include "report.h"
#include "say.h"
#include "signals.h"
#include "used_instruction_set.h"

namespace kinome::app {
namespace {

namespace fs = std::filesystem;

void set_up_log(const Options& options) {
  if (options.quiet) {
    set_log_level(LogLevel::kQuiet);
  } else {
    set_log_level(options.verbosity == 0   ? LogLevel::kWarn
                  : options.verbosity == 1 ? LogLevel::kInfo
                                           : LogLevel::kDebug);
  }
}

LoadOptions load_options(const Options& options) {
  return {
      .defines = options.defines, .search_paths = options.search_paths, .threads = options.threads,
      .lenient = options.lenient};
}

const Sensor& choose_sensor(const Scene& scene, const std::string& wanted) {
  const auto& sensors = scene.sensors();
  const Location where{scene.file()};
  if (sensors.empty()) throw Error(where, "the scene has no sensor");
  std::vector<std::string> ids;
  for (const auto& sensor : sensors) {
    if (sensor->id() == wanted) return *sensor;
    if (!sensor->id().empty()) ids.push_back(sensor->id());
  }
  size_t index = 0;
  const char* end = wanted.data() + wanted.size();
  const auto [rest, error] = std::from_chars(wanted.data(), end, index);
  if (error == std::errc{} && rest == end && index < sensors.size()) return *sensors[index];
  const std::string near = nearest_name(wanted, ids);
  throw Error(where, fmt::format("no sensor '{}': expected an index from 0 to {}{}", wanted,
                                 sensors.size() - 1,
                                 near.empty() ? " or a sensor's id" : " or '" + near + "'"));
}

/// Before anything is loaded. nullptr: no checkpoints are asked for.
std::unique_ptr<Checkpoint> open_checkpoint(const Options& options) {
  if (options.checkpoint.empty()) return nullptr;
  const auto say_that_it_resumes = [&options] {
    if (!options.quiet) say("resuming from {}\n", options.checkpoint);
  };
  auto checkpoint = std::make_unique<Checkpoint>(
      Checkpoint::Options{options.checkpoint, options.every, options.resume, say_that_it_resumes});
  if (options.resume && !options.quiet && !checkpoint->resumes()) {
    say("there is no {}: beginning at the beginning\n", options.checkpoint);
  }
  return checkpoint;
}

/// Of channels that are rendered for nothing.
void warn_of_layers(const Scene& scene, const Film& film) {
  if (film.file_extension() != ".pfm") return;
  if (!scene.integrator().channels().empty()) {
    log_warn(
        "the scene's film writes .pfm files, which hold no channels but colour: those of its "
        "integrator are left out");
  }
}

/// Where plugins are audited: always, and where samples were not finite.
constexpr uint32_t kPlaces = 256;
constexpr uint32_t kPlacesOfSuspects = 1 << 15;

/// Of a picture that was written though a plugin is at fault.
constexpr int kFaultyStatus = 3;

void warn_of_faults(const RenderStats& stats) {
  if (stats.non_finite_samples > 0) {
    log_warn(fmt::format("samples that were not finite, and were dropped: {}",
                         stats.non_finite_samples));
  }
  for (const PluginFault& fault : stats.faults) {
    log_warn(fmt::format("plugin {} is at fault: {}, at {} of {} places", fault.plugin, fault.what,
                         fault.count, fault.looks));
  }
}

int exit_status(const Options& options, const RenderStats& stats) {
  const bool is_faulty = stats.non_finite_samples > 0 || !stats.faults.empty();
  const int signal_status = signal_exit_status();
  return signal_status == 0 && is_faulty && !options.lenient ? kFaultyStatus : signal_status;
}

/// Of what was interrupted.
std::string incompleteness(const RenderStats& stats) {
  const auto percent = [](double share) { return std::ceil(100 * share); };
  std::string text = stats.complete ? "" : ", incomplete";
  if (stats.filled > 0) {
    text += fmt::format(", {} % of it by one sample a pixel", percent(stats.filled));
  }
  if (stats.missing > 0) {
    text += fmt::format(", {} % of it missing (where an EXR's alpha is 0)", percent(stats.missing));
  }
  return text;
}

void report(const Options& options, const RenderStats& stats, const RenderSummary& summary) {
  // With --quiet, too, where it makes the exit status: it must be said why.
  if (options.quiet && exit_status(options, stats) == kFaultyStatus) {
    set_log_level(LogLevel::kWarn);
  }
  warn_of_faults(stats);
  if (!options.quiet) {
    say("wrote {}{} ({:.2f} s)\n", summary.output, incompleteness(stats), stats.total_seconds);
    if (!options.checkpoint.empty() && !stats.complete) {
      say("--resume goes on from {}\n", options.checkpoint);
    }
  }
  if (options.stats == StatsFormat::kText) {
    say("{}", stats_text(stats, summary));
  } else if (options.stats == StatsFormat::kJson) {
    fmt::print("{}", stats_json(stats, summary));
    if (std::fflush(stdout) != 0) throw Error("--stats=json: stdout can't be written");
  }
}

void run_inspection(const Options& options, const Scene& scene, const Sensor& sensor,
                    RenderContext& context, const std::string& output) {
  const Vec2& pixel = *options.inspect;
  // Beside a rendering of the same scene, not in its place.
  const std::string stem =
      fs::path(output).replace_extension("").string() + (options.output.empty() ? "-inspect" : "");
  std::string names;
  try {
    names = inspect(scene, sensor, context, pixel, stem);
  } catch (const Error& error) {
    throw Error(fmt::format("--inspect {},{}: {}", pixel.x, pixel.y, error.what()));
  }
  if (!options.quiet) say("wrote {}\n", names);
}

/// Renders the picture and writes it; whatever else there is to know of it goes to the statistics.
RenderSummary render_and_write(const Options& options, const Scene& scene, const Sensor& sensor,
                               RenderContext& context, Progress& progress,
                               const PluginRegistry& registry, const Output& output,
                               Checkpoint* checkpoint) {
  Film& film = sensor.film();
  RenderStats& stats = context.stats();
  begin_interruptible_render();
  progress.begin();
  log_info(fmt::format("rendering {}x{} pixels of {} on {} threads", film.crop().width(),
                       film.crop().height(), options.scene, context.threads()));
  const Image image = render(scene, sensor, context);
  progress.finish();

  stats.plugins = registry.loaded();
  stats.instruction_set = to_string(used_instruction_set(registry));
  const std::string integrator = integrator_names(stats.plugins);
  const Clock::time_point write_start = Clock::now();
  set_activity("writing the picture");
  write_picture(options, film, image, metadata_of(scene, context, integrator, stats), output,
                checkpoint);
  if (checkpoint && stats.complete) remove_checkpoint(*checkpoint, output);
  stats.write_seconds = seconds_since(write_start);
  set_activity("checking plugins");
  stats.faults = audit_plugins(scene, sensor, options.seed,
                               stats.non_finite_samples > 0 ? kPlacesOfSuspects : kPlaces);
  return {.scene = options.scene,
          .output = output.picture,
          .integrator = integrator,
          .width = image.width,
          .height = image.height,
          .samples = static_cast<unsigned>(std::lround(stats.samples)),
          .seed = options.seed};
}

}  // namespace

/// On stdout, as what was asked for; each line begins with its place, for editors that go there.
int check_command(const Options& options) {
  set_up_log(options);
  const bool has_sensor = options.sensor != Options().sensor;
  for (const auto& [name, is_given] : {std::pair("-o", !options.output.empty()),
                                       std::pair("-s", has_sensor), std::pair("--png", options.png)}) {
    if (is_given) log_warn(fmt::format("{} is ignored: --check renders nothing", name));
  }
  warn_of_missing_folders(options);
  set_activity("loading the scene");
  PluginRegistry registry(PluginRegistry::default_folders(options.plugin_paths),
                          choose_instruction_set(options.isa));
  const std::vector<Error> faults = check_scene(options.scene, load_options(options), registry);
  for (const Error& fault : faults) fmt::print("{}\n", fault.what());
  if (faults.empty()) fmt::print("no faults\n");
  return faults.empty() ? 0 : 1;
}

int render_command(const Options& options, Clock::time_point start) {
  set_up_log(options);
  install_signal_handlers(options.quiet);
  if (!options.variant.empty()) {
    log_warn(fmt::format("-m {} is ignored: kinome has one variant, RGB in single precision",
                         options.variant));
  }
  warn_of_missing_folders(options);
  check_output_folder(options);
  const std::unique_ptr<Checkpoint> checkpoint = open_checkpoint(options);

  Progress progress(options.quiet);
  const Film* film_to_write = nullptr;
  Output output;
  const auto seconds_to_write = [&](const Image& picture) {
    return writing_seconds(options, *film_to_write, picture, output.picture);
  };
  RenderContext context({.threads = options.threads,
                         .seed = options.seed,
                         .cancel = &cancel_flag(),
                         .progress = [&](double fraction) { progress.update(fraction); },
                         .start = start,
                         .budget = {.seconds = options.seconds,
                                    .rel_mse = options.rel_mse,
                                    .lanes = options.renders,
                                    .seconds_after = seconds_to_write}});
  RenderStats& stats = context.stats();
  PluginRegistry registry(PluginRegistry::default_folders(options.plugin_paths),
                          choose_instruction_set(options.isa));
  set_activity("loading the scene");
  const auto scene = load_scene(options.scene, load_options(options), registry, &stats);
  warn_of_unused_instruction_set(options, registry);
  const Sensor& sensor = choose_sensor(*scene, options.sensor);
  film_to_write = &sensor.film();
  output = choose_output(options, sensor.film());
  warn_of_layers(*scene, sensor.film());
  if (checkpoint) {
    for (const std::string& written : output.files()) {
      if (!checkpoint->is_written_to(written)) continue;
      throw Error(
          fmt::format("--checkpoint {}: this is where the picture goes", checkpoint->path()));
    }
    checkpoint->set_identity(
        identity_of(options, *scene, sensor, used_instruction_set(registry)));
    context.set_checkpoint(checkpoint.get());
  }

  set_activity("rendering");
  if (options.inspect) {
    run_inspection(options, *scene, sensor, context, output.picture);
    return 0;
  }
  const RenderSummary summary = render_and_write(options, *scene, sensor, context, progress,
                                                 registry, output, checkpoint.get());
  stats.total_seconds = seconds_since(start);
  stats.peak_memory_bytes = peak_memory_bytes();
  warn_of_missed_budget(context.budget(), stats, stats.total_seconds, {});
  report(options, stats, summary);
  return exit_status(options, stats);
}

}  // namespace kinome::app
