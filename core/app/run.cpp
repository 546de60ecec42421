#include <charconv>
#include <cstdio>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "commands.h"
#include "inspect.h"
#include "kinome/log.h"
#include "kinome/render_context.h"
#include "kinome/scene_loader.h"
#include "progress.h"
#include "report.h"
#include "signals.h"

namespace kinome::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void set_up_log(const Options& options) {
  if (options.quiet) {
    set_log_level(LogLevel::kQuiet);
  } else {
    set_log_level(options.verbosity == 0   ? LogLevel::kWarn
                  : options.verbosity == 1 ? LogLevel::kInfo
                                           : LogLevel::kDebug);
  }
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

/// Where the picture goes: beside the scene file, or as -o says, with the film's extension. Another
/// image format's extension is a mistake: what is written would not be what the name says.
std::string output_path(const Options& options, const std::string& extension) {
  if (options.output.empty()) return fs::path(options.scene).replace_extension(extension).string();
  static const std::set<std::string> kImages = {".exr", ".pfm", ".png",  ".jpg", ".jpeg",
                                                ".hdr", ".tif", ".tiff", ".bmp", ".rgbe"};
  const std::string given = fs::path(options.output).extension().string();
  if (given == extension) return options.output;
  if (kImages.count(given) != 0) {
    throw Error(fmt::format("-o {}: the scene's film writes {} files{}", options.output, extension,
                            given == ".png" ? "; --png adds a PNG beside it" : ""));
  }
  return options.output + extension;
}

/// Before anything is loaded: the film will choose the extension, but not the folder.
void check_output_folder(const Options& options) {
  std::error_code ignored;
  if (!fs::exists(options.scene, ignored)) return;  // the greater mistake, which the loader reports
  if (options.output.empty()) {
    check_writable(fs::path(options.scene).replace_extension(".exr").string());
  } else {
    const bool whole =
        fs::is_directory(options.output, ignored) || fs::path(options.output).has_extension();
    check_writable(whole ? options.output : options.output + ".exr");
  }
}

ImageMetadata metadata_of(const Scene& scene, const Sensor& sensor, const RenderContext& context,
                          const std::string& integrator, const RenderStats& stats) {
  return {
      {"kinome:version", KINOME_VERSION},
      {"kinome:scene", scene.file()},
      {"kinome:scene_hash", scene.hash()},
      {"kinome:integrator", integrator},
      {"kinome:samples", std::to_string(sensor.sampler().sample_count())},
      {"kinome:seed", std::to_string(context.seed())},
      {"kinome:plugins", fmt::format("{}", fmt::join(stats.plugins, " "))},
      {"kinome:complete", stats.complete ? "true" : "false"},
  };
}

/// Names of the loaded integrators (an aov integrator nests others).
std::string integrator_names(const std::vector<std::string>& plugins) {
  const std::string prefix = std::string(to_string(Category::kIntegrator)) + "/";
  std::string names;
  for (const std::string& plugin : plugins) {
    if (plugin.rfind(prefix, 0) != 0) continue;
    names += (names.empty() ? "" : " ") + plugin.substr(prefix.size());
  }
  return names;
}

void report(const Options& options, const RenderStats& stats, const RenderSummary& summary) {
  if (stats.non_finite_samples > 0) {
    log_warn(fmt::format("samples that were not finite, and were dropped: {}",
                         stats.non_finite_samples));
  }
  if (!options.quiet) {
    fmt::print(stderr, "wrote {}{} ({:.2f} s)\n", summary.output,
               stats.complete ? "" : ", incomplete", stats.total_seconds);
  }
  if (options.stats == StatsFormat::kText) {
    fmt::print(stderr, "{}", stats_text(stats, summary));
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
  if (!options.quiet) fmt::print(stderr, "wrote {}\n", names);
}

}  // namespace

int render_command(const Options& options, Clock::time_point start) {
  set_up_log(options);
  install_signal_handlers(options.quiet);
  if (!options.variant.empty()) {
    log_warn(fmt::format("-m {} is ignored: kinome has one variant, RGB in single precision",
                         options.variant));
  }
  check_output_folder(options);

  Progress progress(options.quiet);
  RenderContext context({.threads = options.threads,
                         .seed = options.seed,
                         .cancel = &cancel_flag(),
                         .progress = [&](double fraction) { progress.update(fraction); },
                         .start = start});
  RenderStats& stats = context.stats();
  PluginRegistry registry(PluginRegistry::default_folders(options.plugin_paths));
  const auto scene = load_scene(options.scene,
                                {.defines = options.defines,
                                 .search_paths = options.search_paths,
                                 .threads = options.threads},
                                registry, &stats);
  const Sensor& sensor = choose_sensor(*scene, options.sensor);
  const Film& film = sensor.film();
  const std::string output = options.inspect && fs::path(options.output).extension() == ".png"
                                 ? options.output
                                 : output_path(options, film.file_extension());
  const std::string png = fs::path(output).replace_extension(".png").string();
  check_writable(output);
  if (options.png) check_writable(png);

  if (options.inspect) {
    run_inspection(options, *scene, sensor, context, output);
    return 0;
  }
  begin_interruptible_render();
  progress.begin();
  log_info(fmt::format("rendering {}x{} pixels of {} on {} threads", film.crop().width(),
                       film.crop().height(), options.scene, context.threads()));
  const Image image = render(*scene, sensor, context);
  progress.finish();

  stats.plugins = registry.loaded();
  const std::string integrator = integrator_names(stats.plugins);
  const Clock::time_point write_start = Clock::now();
  film.write(output, image, metadata_of(*scene, sensor, context, integrator, stats));
  if (options.png) write_png(png, image, options.exposure);
  stats.write_seconds = seconds_since(write_start);
  stats.total_seconds = seconds_since(start);
  stats.peak_memory_bytes = peak_memory_bytes();
  report(options, stats,
         {.scene = options.scene,
          .output = output,
          .integrator = integrator,
          .width = image.width,
          .height = image.height,
          .samples = sensor.sampler().sample_count(),
          .seed = options.seed});
  return signal_exit_status();
}

}  // namespace kinome::app
