// `kinome film`: renders the frames of a changing scene, and encodes them as a video.

#include <algorithm>
#include <future>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/clock.h"
#include "base/fnv1a.h"
#include "commands.h"
#include "crash.h"
#include "film/film_edits.h"
#include "film/film_frames.h"
#include "film/video.h"
#include "images/denoising.h"
#include "images/image_formats.h"
#include "kinome/log.h"
#include "kinome/read_files.h"
#include "kinome/render.h"
#include "options/sensor_index.h"
#include "render/crop.h"
#include "render/progress.h"
#include "render/render_image.h"
#include "say.h"
#include "signals.h"

namespace kinome::app {
namespace {

/// Separates seeds of frames from other derived seeds.
constexpr uint64_t kFrameSeed = 0x66696c6d;

/// Returns the seed of a frame: noise of different frames is independent.
uint64_t seed_of(const Options& options, int frame) {
  return hash_words(options.seed, static_cast<uint64_t>(frame), kFrameSeed);
}

std::string hash_of_file(const std::string& path) {
  const std::string text = file_contents(path);
  Fnv1a hash;
  hash.add(text.data(), text.size());
  return fmt::format("{:016x}", hash.value());
}

std::string text_of(const std::optional<glm::dvec3>& v) {
  return v ? fmt::format("{:g},{:g},{:g}", v->x, v->y, v->z) : "the scene's";
}

/// A frame that is rendered, and whose files are written.
struct RenderedFrame {
  Output files;
  Image image;
  ImageMetadata metadata;
  RenderStats stats;
  RenderSummary summary;
  std::shared_ptr<const Sensor> sensor;  ///< owner of the film that writes the image
  Clock::time_point start;
};

class FilmCommand {
 public:
  FilmCommand(const Options& options, Clock::time_point start)
      : options_(options),
        film_(options.film),
        start_(start),
        frames_(options.output, options.scene),
        registry_(PluginRegistry::default_folders(options.plugin_paths),
                  choose_instruction_set(options.isa)),
        progress_(options.quiet),
        setup_(denoising_setup(options)) {}

  int run() {
    load();
    list_missing();
    if (!options_.display.empty()) {
      const std::string& name = frames_.video().empty() ? frames_.pattern() : frames_.video();
      display_ = std::make_unique<Display>(options_.display, name);
    }
    begin_interruptible_render();
    progress_.begin();
    for (const int frame : missing_) {
      if (cancel_flag() || !render(frame)) break;
      ++done_;
    }
    finish_writing();
    progress_.finish();
    return finish();
  }

 private:
  /// Loads the scene and the keys. Finds all errors of the user before the first frame.
  void load() {
    if (!options_.display.empty()) split_address(options_.display);
    if (film_.path != "orbit" && film_.path != "ellipse") {
      record_read_file(film_.path);
      keys_.emplace(film_.path);
    }
    if (!frames_.video().empty() && !has_ffmpeg()) {
      log_warn(
          fmt::format("ffmpeg not found: writing PNG frames, {}, and no video", frames_.pattern()));
    }
    denoising_ = denoising_of(options_);
    set_activity("loading the scene");
    LoadOptions load = load_options(options_);
    load.denoising = setup_;
    editor_.emplace(options_.scene, load, registry_, &load_stats_);
    warn_of_unused_instruction_set(options_, registry_);
    const auto scene = editor_->scene();
    sensor_ = sensor_index(*scene, options_.sensor);
    const Sensor& sensor = cropped_sensor(*scene);
    if (!frames_.are_png()) warn_of_layers(*scene, sensor.film(), {frames_.name(film_.first), ""});
    edits_.emplace(film_, keys_ ? &*keys_ : nullptr, *editor_, sensor_);
    try {
      for (const FilmEdits::Values& values : edits_->at_keys()) {
        editor_->set(values);
        editor_->update();
      }
    } catch (const Error& error) {
      throw Error(Location{film_.path}, error.what());
    }
    frames_.make_folder();
    cropped_sensor(*editor_->scene());
    output(0);  // throws if the scene's film can't write it
    frames_.claim(identity(*scene, sensor), film_.frames);
  }

  /// Returns the sensor, whose film has the window of --crop. An update may have replaced it.
  const Sensor& cropped_sensor(const Scene& scene) const {
    const Sensor& sensor = *scene.sensors()[sensor_];
    apply_crop(options_, sensor);
    return sensor;
  }

  Checkpoint::Identity identity(const Scene& scene, const Sensor& sensor) const {
    Checkpoint::Identity identity =
        identity_of(options_, scene, sensor, used_instruction_set(registry_));
    identity["--path"] = film_.path;
    if (keys_) identity["keys (by their text)"] = hash_of_file(film_.path);
    identity["--frames"] = std::to_string(film_.frames);
    identity["--time"] = fmt::format("{:g}", options_.seconds);
    identity["--angles"] = fmt::format("{:g},{:g}", film_.angles.x, film_.angles.y);
    identity["--target"] = text_of(film_.target);
    identity["--up"] = text_of(film_.up);
    if (options_.png || stores_srgb(lower_extension(frames_.name(0)), &sensor.film())) {
      identity["--exposure"] = fmt::format("{:g}", options_.exposure);
    }
    return identity;
  }

  Output output(int frame) const {
    return frames_.output(frame, options_, editor_->scene()->sensors()[sensor_]->film());
  }

  void list_missing() {
    for (int frame = film_.first; frame <= film_.last; ++frame) {
      if (!FilmFrames::exists(output(frame))) missing_.push_back(frame);
    }
    const size_t requested = static_cast<size_t>(film_.last) - film_.first + 1;
    if (!options_.quiet && missing_.size() < requested) {
      say("{} of {} frames exist: rendering the others\n", requested - missing_.size(), requested);
    }
  }

  /// Renders a frame and begins to write it. Returns false, without writing it, if it was
  /// interrupted.
  bool render(int frame) {
    const Clock::time_point start = Clock::now();
    set_activity("loading the scene");
    editor_->set(edits_->at_frame(frame));
    const SceneChanges changes = editor_->update();
    log_debug(fmt::format("frame {}: rebuilt {}{}", frame, fmt::join(changes.made, " "),
                          changes.has_new_structure ? " and the acceleration structure" : ""));
    const auto scene = editor_->scene();
    const Sensor& sensor = cropped_sensor(*scene);
    const Output files = output(frame);
    const auto seconds_to_finish = [&](Image image) {
      const double denoise = denoising_ ? denoising_->measure(image, *setup_, sensor.film()) : 0;
      return denoise + writing_seconds(options_, sensor.film(), image, files);
    };
    RenderContext context({.threads = options_.threads,
                           .seed = seed_of(options_, frame),
                           .cancel = &cancel_flag(),
                           .progress = [&](double fraction) { report_progress(fraction); },
                           .start = start,
                           .budget = {.seconds = options_.seconds,
                                      .rel_mse = options_.rel_mse,
                                      .lanes = renders_for_noise(options_, sensor),
                                      .seconds_after = seconds_to_finish}});
    RenderStats& stats = context.job.stats();
    stats.left_out = load_stats_.left_out;
    stats.skipped = load_stats_.skipped;
    // The scene is loaded once, for the first frame; each frame adds the time of its update.
    const double update_seconds = seconds_since(start);
    stats.load_seconds = update_seconds + std::exchange(load_stats_.load_seconds, 0);
    stats.plugin_seconds = std::exchange(load_stats_.plugin_seconds, 0);
    stats.build_seconds = std::exchange(load_stats_.build_seconds, 0);
    Image image = render_image(options_, *scene, sensor, context, display_.get());
    if (!stats.complete) return false;
    if (denoising_) image = denoising_->denoise(image, *setup_, sensor.film(), stats);
    finish_writing();
    ImageMetadata metadata = describe_image(options_, *scene, context, registry_);
    audit_render(*scene, sensor, context);
    RenderSummary summary = summary_of(options_, sensor, context, image, files);
    begin_writing({files, std::move(image), std::move(metadata), std::move(stats),
                   std::move(summary), scene->sensors()[sensor_], start});
    return true;
  }

  /// Writes the files of a frame while the next one is rendered. Writes them at once if one thread
  /// must do all work, or if the next frame has a time limit, which writing would disturb.
  void begin_writing(RenderedFrame frame) {
    frame_ = std::move(frame);
    const auto write = [this] {
      const Clock::time_point start = Clock::now();
      write_image_files(options_, frame_->sensor->film(), frame_->image, frame_->metadata,
                        frame_->files, nullptr);
      frame_->stats.write_seconds = seconds_since(start);
      frame_->stats.total_seconds = seconds_since(frame_->start);
      frame_->stats.peak_memory_bytes = peak_memory_bytes();
    };
    const bool is_at_once = options_.threads == 1 || options_.seconds > 0;
    // Without further threads, get() writes the files.
    constexpr auto kAnyThread = std::launch::async | std::launch::deferred;
    writing_ = std::async(is_at_once ? std::launch::deferred : kAnyThread, write);
    if (is_at_once) finish_writing();
  }

  /// Waits until the last frame is written, and reports it. Throws Error if that failed.
  void finish_writing() {
    if (!writing_.valid()) return;
    set_activity("writing the image");
    writing_.get();
    log_info(fmt::format("wrote {} ({:.2f} s)", frame_->files.name(), frame_->stats.total_seconds));
    report(frame_->stats, frame_->summary);
    frame_.reset();
  }

  /// Reports a frame. Only the first faults are reported, because most frames have the same ones.
  void report(const RenderStats& stats, const RenderSummary& summary) {
    const bool is_faulty = stats.non_finite_samples > 0 || !stats.faults.empty();
    if (is_faulty && !is_faulty_) report_faults(options_, stats);
    is_faulty_ = is_faulty_ || is_faulty;
    warn_of_missed_budget({.seconds = options_.seconds, .rel_mse = options_.rel_mse}, stats,
                          stats.total_seconds, {.work = "render {} and write"});
    print_statistics(options_, stats, summary);
  }

  void report_progress(double fraction) {
    const double done = (done_ + fraction) / static_cast<double>(missing_.size());
    shown_progress_ = std::max(shown_progress_, done);  // each pass over a frame restarts at 0
    progress_.update(shown_progress_);
  }

  int finish() {
    if (display_) display_->finish();
    std::vector<Output> all;
    for (int frame = 0; frame < film_.frames; ++frame) all.push_back(output(frame));
    const auto finished = std::count_if(all.begin(), all.end(), &FilmFrames::exists);
    const bool is_whole = finished == film_.frames;
    std::string written = frames_.pattern();
    if (is_whole && !frames_.video().empty() && has_ffmpeg() && !cancel_flag()) {
      set_activity("making the video");
      make_video(frames_.pattern(), film_.rate, frames_.video());
      frames_.remove(all);
      written = frames_.video();
    }
    if (!options_.quiet) {
      if (is_whole && signal_exit_status() == 0) {
        say("wrote {}: {} frame{}, {:g} s ({:.2f} s)\n", written, film_.frames,
            film_.frames == 1 ? "" : "s", film_.frames / film_.rate, seconds_since(start_));
      } else {
        say("{}: {} of {} frames finished{}\n", written, finished, film_.frames,
            signal_exit_status() == 0 ? "" : ", incomplete: run the same command to continue");
      }
    }
    RenderStats stats;
    stats.non_finite_samples = is_faulty_ ? 1 : 0;
    return exit_status(options_, stats);
  }

  const Options& options_;
  const FilmOptions& film_;
  const Clock::time_point start_;
  FilmFrames frames_;
  PluginRegistry registry_;
  Progress progress_;
  RenderStats load_stats_;
  std::optional<Denoising> denoising_;
  const std::shared_ptr<DenoisingSetup> setup_;
  std::optional<FilmKeys> keys_;
  std::optional<SceneEditor> editor_;
  std::optional<FilmEdits> edits_;
  size_t sensor_ = 0;
  std::unique_ptr<Display> display_;
  std::vector<int> missing_;  ///< frames to render
  size_t done_ = 0;           ///< number of missing_ that are finished
  double shown_progress_ = 0;
  bool is_faulty_ = false;
  std::optional<RenderedFrame> frame_;  ///< frame that is being written; nullopt if none is
  std::future<void> writing_;           ///< destroyed first, because its destructor waits
};

}  // namespace

int film_command(const Options& options, Clock::time_point start) {
  set_up_render(options);
  return FilmCommand(options, start).run();
}

}  // namespace kinome::app
