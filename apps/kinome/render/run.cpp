// `kinome SCENE`: renders a scene file, or checks it with --check.

#include <cmath>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "base/clock.h"
#include "commands.h"
#include "crash.h"
#include "farm/group.h"
#include "images/denoising.h"
#include "kinome/checkpoint.h"
#include "kinome/log.h"
#include "kinome/output_files.h"
#include "kinome/render.h"
#include "options/sensor_index.h"
#include "output_files/file_writer.h"
#include "render/crop.h"
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
                                              ImagePart{options.part - 1, options.parts});
  } catch (const Error& error) {
    throw Error(fmt::format("--part {}: {}", part_text(options), error.what()));
  }
}

/// Render of a scene file, from the options to the written files.
class SceneRender {
 public:
  /// `group` is nullptr outside of MPI. `start` is the start of the program.
  SceneRender(const Options& options, ProcessGroup* group, Clock::time_point start)
      : options_(options),
        group_(group),
        is_root_(!group || group->is_root()),
        start_(start),
        progress_(options.quiet) {}

  /// Returns the exit status. Call once.
  int run();

 private:
  void check_files();
  void load();
  void check_written_files() const;
  double seconds_to_finish(Image image);
  RenderContext make_context();
  int finish(RenderContext& context, Image image);
  /// Ends the stage of the timeline in which only one thread works.
  void end_serial(const char* stage) {
    if (timeline_) timeline_->end_serial(stage);
  }

  const Options& options_;
  ProcessGroup* const group_;
  const bool is_root_;
  const Clock::time_point start_;
  std::unique_ptr<Checkpoint> checkpoint_;  ///< nullptr without --checkpoint
  Progress progress_;
  Output output_;
  std::optional<Denoising> denoising_;
  std::shared_ptr<DenoisingSetup> setup_;
  std::optional<Timeline> timeline_;
  RenderStats loaded_;  ///< statistics of loading the scene
  std::optional<PluginRegistry> registry_;
  std::shared_ptr<const Scene> scene_;
  const Sensor* sensor_ = nullptr;
  std::unique_ptr<const PartRender> part_;  ///< nullptr unless --part requests a single part
  Checkpoint::Identity identity_;
};

/// Checks the files that --output, --trace and --checkpoint name, before the scene is loaded.
void SceneRender::check_files() {
  if (!is_root_) return;
  check_output_folder(options_);
  if (!options_.trace.empty()) check_writable(options_.trace);
  if (!options_.display.empty()) split_address(options_.display);
  checkpoint_ = open_checkpoint(options_);
  if (checkpoint_ && !options_.trace.empty() && checkpoint_->is_written_to(options_.trace)) {
    throw Error(fmt::format("--trace {}: must differ from the checkpoint", options_.trace));
  }
}

void SceneRender::load() {
  if (is_root_) denoising_ = denoising_of(options_);
  LoadOptions load = load_options(options_);
  load.denoising = setup_;
  scene_ = load_scene(options_.scene, load, *registry_, &loaded_);
  warn_of_unused_instruction_set(options_, *registry_);
  sensor_ = scene_->sensors()[sensor_index(*scene_, options_.sensor)].get();
  apply_crop(options_, *sensor_);
  identity_ = identity_of(options_, *scene_, *sensor_, used_instruction_set(*registry_));
  if (is_root_) output_ = choose_output(options_, sensor_->film());
  part_ = part_to_render(options_, *scene_, *sensor_);
  warn_of_layers(*scene_, sensor_->film(), output_);
  check_written_files();
}

/// Checks that the written files differ from each other and from the files of the scene.
void SceneRender::check_written_files() const {
  if (is_root_ && !options_.trace.empty()) check_writable(options_.trace);
  for (const std::string& written : output_.files()) {
    if (!options_.trace.empty() && are_written_to_one_file(written, options_.trace)) {
      throw Error(fmt::format("--trace {}: must differ from the output file", options_.trace));
    }
    if (!checkpoint_ || !checkpoint_->is_written_to(written)) continue;
    throw Error(
        fmt::format("--checkpoint {}: must differ from the output file", checkpoint_->path()));
  }
}

/// Estimates the seconds that finish() needs for an image like `image`.
double SceneRender::seconds_to_finish(Image image) {
  const Film& film = sensor_->film();
  const double denoise = denoising_ ? denoising_->measure(image, *setup_, film) : 0;
  return denoise + writing_seconds(options_, film, image, output_);
}

RenderContext SceneRender::make_context() {
  return RenderContext(
      {.threads = options_.threads,
       .seed = options_.seed,
       .cancel = &cancel_flag(),
       .progress = [this](double fraction) { progress_.update(fraction); },
       .start = start_,
       .budget = {.seconds = options_.seconds,
                  .rel_mse = options_.rel_mse,
                  .lanes = renders_for_noise(options_, *sensor_),
                  .seconds_after =
                      [this](Image image) { return seconds_to_finish(std::move(image)); }},
       .group = group_,
       .timeline = timeline_ ? &*timeline_ : nullptr});
}

/// Writes and reports the image. Returns the exit status, which is 0 except on the root.
int SceneRender::finish(RenderContext& context, Image image) {
  if (!is_root_) return 0;
  RenderStats& stats = context.job.stats();
  if (denoising_) image = denoising_->denoise(image, *setup_, sensor_->film(), stats);
  RenderSummary summary = finish_image(options_, *scene_, *sensor_, context, *registry_, image,
                                       output_, checkpoint_.get(), part_.get(), setup_.get());
  stats.total_seconds = seconds_since(start_);
  end_serial("write");
  if (timeline_) summary.stage_threads = stage_threads(*timeline_, context.scheduler.threads());
  if (!options_.trace.empty()) write_text(options_.trace, trace_json(*timeline_));
  stats.peak_memory_bytes = peak_memory_bytes();
  warn_of_missed_budget(context.job.budget(), stats, stats.total_seconds, {});
  report(options_, stats, summary);
  return exit_status(options_, stats);
}

int SceneRender::run() {
  set_up_render(options_);
  on_all_processes(group_, [&] { check_files(); });
  setup_ = denoising_setup(options_);
  if (options_.stats != StatsFormat::kNone || !options_.trace.empty()) timeline_.emplace(start_);
  registry_.emplace(PluginRegistry::default_folders(options_.plugin_paths),
                    choose_instruction_set(options_.isa));
  set_activity("loading the scene");
  on_all_processes(group_, [&] { load(); });
  if (group_) check_alike(*group_, identity_);
  RenderContext context = make_context();
  // The scheduler has counted threads and processes.
  loaded_.threads = context.job.stats().threads;
  loaded_.processes = context.job.stats().processes;
  context.job.stats() = std::move(loaded_);
  if (checkpoint_) {
    checkpoint_->set_identity(identity_);
    context.job.set_work_source(checkpoint_.get());
  }

  if (options_.inspect) {
    set_activity("rendering");
    run_inspection(options_, *scene_, *sensor_, context, output_.image);
    return 0;
  }
  std::unique_ptr<Display> display;
  if (!options_.display.empty()) {
    display = std::make_unique<Display>(options_.display, output_.image);
  }
  end_serial("load");
  begin_interruptible_render(group_ != nullptr);
  progress_.begin();
  Image image = render_image(options_, *scene_, *sensor_, context, display.get(), part_.get());
  progress_.finish();
  end_serial("develop");
  int status = 0;
  on_all_processes(group_, [&] { status = finish(context, std::move(image)); });
  return status;
}

}  // namespace

int render_command(const Options& options, Clock::time_point start) {
  const std::unique_ptr<ProcessGroup> group = join_group(options);
  if (!group) return SceneRender(options, nullptr, start).run();
  return run_in_group(*group, [&] {
    // Options that determine when processes wait for each other.
    check_alike(*group, {{"--inspect", options.inspect ? "given" : ""},
                         {"--time", fmt::format("{}", options.seconds)},
                         {"--error", fmt::format("{}", options.rel_mse)},
                         {"--variance", std::to_string(options.renders)},
                         {"--part", std::to_string(options.parts)}});
    if (options.inspect)
      throw AgreedError("--inspect: unsupported under MPI: run it without mpirun");
    const Options own = options_in(*group, options);
    return SceneRender(own, group.get(), start).run();
  });
}

}  // namespace kinome::app
