// `kinome SCENE`: renders a scene file, or checks it with --check.

#include <cmath>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "base/clock.h"
#include "commands.h"
#include "crash.h"
#include "farm/group.h"
#include "kinome/checkpoint.h"
#include "kinome/log.h"
#include "kinome/output_files.h"
#include "kinome/render.h"
#include "options/sensor_index.h"
#include "output_files/file_writer.h"
#include "render/crop.h"
#include "render/denoising.h"
#include "render/inspect.h"
#include "render/progress.h"
#include "render/render_image.h"
#include "render/trace_file.h"
#include "say.h"
#include "signals.h"

namespace kinome::app {
namespace {

namespace fs = std::filesystem;

/// Opens the checkpoint, before the scene is loaded; returns nullptr without --checkpoint.
std::unique_ptr<Checkpoint> open_checkpoint(const Options& options) {
  if (options.checkpoint.empty()) return nullptr;
  const auto report_resume = [&options] {
    if (!options.quiet) say("resuming from {}\n", options.checkpoint);
  };
  auto checkpoint = std::make_unique<Checkpoint>(
      Checkpoint::Options{options.checkpoint, options.every, options.resume, report_resume});
  if (options.resume && !options.quiet && !checkpoint->resumes()) {
    say("no checkpoint {}: starting from the beginning\n", options.checkpoint);
  }
  return checkpoint;
}

void run_inspection(const Options& options, const Scene& scene, const Sensor& sensor,
                    RenderContext& context, const std::string& output) {
  const Vec2& pixel = *options.inspect;
  // The default name differs from that of a render, so that it isn't overwritten.
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

/// Describes an interrupted render; "" if it is complete.
std::string incompleteness(const RenderStats& stats) {
  const auto percent = [](double share) { return std::ceil(100 * share); };
  std::string text = stats.complete ? "" : ", incomplete";
  if (stats.filled > 0) {
    text += fmt::format(", {} % of the pixels with one sample", percent(stats.filled));
  }
  if (stats.missing > 0) {
    text += fmt::format(", {} % of the pixels missing (alpha 0 in an EXR)", percent(stats.missing));
  }
  return text;
}

void report(const Options& options, const RenderStats& stats, const RenderSummary& summary) {
  report_faults(options, stats);
  const bool has_budget = options.seconds > 0 || options.rel_mse > 0;
  if (has_budget && !options.quiet && !stats.method.empty()) {
    say("method: {}\n", stats.method);
  }
  if (!options.quiet) {
    say("wrote {}{} ({:.2f} s)\n", summary.output, incompleteness(stats), stats.total_seconds);
    if (!options.checkpoint.empty() && !stats.complete) {
      say("--resume continues from {}\n", options.checkpoint);
    }
  }
  print_statistics(options, stats, summary);
}

}  // namespace

/// Prints the errors of a scene to stdout. Each line begins with file and line, which editors can
/// open.
int check_command(const Options& options) {
  set_up_log(options);
  const bool has_sensor = options.sensor != Options().sensor;
  for (const auto& [name, is_given] :
       {std::pair("-o", !options.output.empty()), std::pair("-s", has_sensor),
        std::pair("--png", options.png), std::pair("--crop", options.crop.has_value()),
        std::pair("--display", !options.display.empty()), std::pair("--part", options.parts > 0),
        std::pair("--denoise", options.denoise), std::pair("--trace", !options.trace.empty())}) {
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

namespace {

/// Returns the part that --part requests; nullptr for the whole image and for all parts.
std::unique_ptr<const PartRender> part_to_render(const Options& options, const Scene& scene,
                                                 const Sensor& sensor) {
  if (options.part == 0) return nullptr;
  try {
    return std::make_unique<const PartRender>(scene, sensor,
                                              PicturePart{options.part - 1, options.parts});
  } catch (const Error& error) {
    throw Error(fmt::format("--part {}: {}", part_text(options), error.what()));
  }
}

/// Renders the scene; `group` is nullptr outside of MPI.
int render_scene(const Options& options, ProcessGroup* group, Clock::time_point start) {
  set_up_render(options);
  const bool is_root = !group || group->is_root();
  std::unique_ptr<Checkpoint> checkpoint;
  together(group, [&] {
    if (!is_root) return;
    check_output_folder(options);
    if (!options.trace.empty()) check_writable(options.trace);
    if (!options.display.empty()) split_address(options.display);
    checkpoint = open_checkpoint(options);
    if (checkpoint && !options.trace.empty() && checkpoint->is_written_to(options.trace)) {
      throw Error(fmt::format("--trace {}: must differ from the checkpoint", options.trace));
    }
  });

  Progress progress(options.quiet);
  const Film* film_to_write = nullptr;
  Output output;
  std::optional<Denoising> denoising;
  const std::shared_ptr<DenoisingSetup> setup = denoising_setup(options);
  const auto seconds_to_finish = [&](Image image) {
    const double denoise = denoising ? denoising->measure(image, *setup, *film_to_write) : 0;
    return denoise + writing_seconds(options, *film_to_write, image, output);
  };
  std::optional<Timeline> timeline;
  if (options.stats != StatsFormat::kNone || !options.trace.empty()) timeline.emplace(start);
  const auto end_serial = [&timeline](const char* stage) {
    if (timeline) timeline->end_serial(stage);
  };
  RenderStats loaded;
  PluginRegistry registry(PluginRegistry::default_folders(options.plugin_paths),
                          choose_instruction_set(options.isa));
  set_activity("loading the scene");
  std::shared_ptr<const Scene> scene;
  const Sensor* sensor = nullptr;
  std::unique_ptr<const PartRender> part;
  Checkpoint::Identity identity;
  together(group, [&] {
    if (is_root) denoising = denoising_of(options);
    LoadOptions load = load_options(options);
    load.denoising = setup;
    scene = load_scene(options.scene, load, registry, &loaded);
    warn_of_unused_instruction_set(options, registry);
    sensor = scene->sensors()[sensor_index(*scene, options.sensor)].get();
    apply_crop(options, *sensor);
    identity = identity_of(options, *scene, *sensor, used_instruction_set(registry));
    film_to_write = &sensor->film();
    if (is_root) output = choose_output(options, sensor->film());
    part = part_to_render(options, *scene, *sensor);
    warn_of_layers(*scene, sensor->film(), output);
    if (is_root && !options.trace.empty()) check_writable(options.trace);  // no file of the scene
    for (const std::string& written : output.files()) {
      if (!options.trace.empty() && are_written_to_one_file(written, options.trace)) {
        throw Error(fmt::format("--trace {}: must differ from the output file", options.trace));
      }
      if (!checkpoint || !checkpoint->is_written_to(written)) continue;
      throw Error(
          fmt::format("--checkpoint {}: must differ from the output file", checkpoint->path()));
    }
  });
  if (group) check_alike(*group, identity);
  RenderContext context({.threads = options.threads,
                         .seed = options.seed,
                         .cancel = &cancel_flag(),
                         .progress = [&](double fraction) { progress.update(fraction); },
                         .start = start,
                         .budget = {.seconds = options.seconds,
                                    .rel_mse = options.rel_mse,
                                    .lanes = renders_for_noise(options, *sensor),
                                    .seconds_after = seconds_to_finish},
                         .group = group,
                         .timeline = timeline ? &*timeline : nullptr});
  RenderStats& stats = context.job.stats();
  // The scheduler has counted threads and processes.
  loaded.threads = stats.threads;
  loaded.processes = stats.processes;
  stats = std::move(loaded);
  if (checkpoint) {
    checkpoint->set_identity(identity);
    context.job.set_work_source(checkpoint.get());
  }

  if (options.inspect) {
    set_activity("rendering");
    run_inspection(options, *scene, *sensor, context, output.image);
    return 0;
  }
  std::unique_ptr<Display> display;
  if (!options.display.empty()) {
    display = std::make_unique<Display>(options.display, output.image);
  }
  end_serial("load");
  begin_interruptible_render(group != nullptr);
  progress.begin();
  Image image = render_image(options, *scene, *sensor, context, display.get(), part.get());
  progress.finish();
  end_serial("develop");
  int status = 0;
  together(group, [&] {
    if (!is_root) return;
    if (denoising) image = denoising->denoise(image, *setup, sensor->film(), stats);
    RenderSummary summary = finish_image(options, *scene, *sensor, context, registry, image, output,
                                         checkpoint.get(), part.get(), setup.get());
    stats.total_seconds = seconds_since(start);
    end_serial("write");
    if (timeline) summary.stage_threads = stage_threads(*timeline, context.scheduler.threads());
    if (!options.trace.empty()) write_text(options.trace, trace_json(*timeline));
    stats.peak_memory_bytes = peak_memory_bytes();
    warn_of_missed_budget(context.job.budget(), stats, stats.total_seconds, {});
    report(options, stats, summary);
    status = exit_status(options, stats);
  });
  return status;
}

}  // namespace

int render_command(const Options& options, Clock::time_point start) {
  const std::unique_ptr<ProcessGroup> group = join_group(options);
  if (!group) return render_scene(options, nullptr, start);
  return run_in_group(*group, [&] {
    // Options that determine when processes wait for each other.
    check_alike(*group, {{"--inspect", options.inspect ? "given" : ""},
                         {"--time", fmt::format("{}", options.seconds)},
                         {"--error", fmt::format("{}", options.rel_mse)},
                         {"--variance", std::to_string(options.renders)},
                         {"--part", std::to_string(options.parts)}});
    if (options.inspect)
      throw AgreedError("--inspect: unsupported under MPI: run it without mpirun");
    return render_scene(options_in(*group, options), group.get(), start);
  });
}

}  // namespace kinome::app
