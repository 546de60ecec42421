// The thread of a RenderSession: loads the scene, renders it and publishes images.

#include "session/render_session.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "options/sensor_index.h"
#include "kinome/primary_rays.h"
#include "kinome/render.h"
#include "session/preview_sensor.h"

namespace kinome::viewer {
namespace {

/// Time after the last change at which a movement has ended.
constexpr std::chrono::milliseconds kStillInterval{150};
/// Width of the first preview as a fraction of the film's.
constexpr double kInitialScale = 0.18;
constexpr double kMinScale = 1. / 16;
constexpr size_t kMaxMessages = 200;

/// Integrators of previews, for scenes without media and with media.
constexpr const char* kPreviewIntegrator = "path";
constexpr const char* kMediaPreviewIntegrator = "volpath";

/// Returns true if an integrator has a preparation stage, such as learning, before the camera rays.
/// Such a stage takes too long for a preview.
bool is_slow_to_begin(const Integrator& integrator) {
  for (const Stage& stage : integrator.stages()) {
    if (std::string_view(stage.name) == kPrimaryStage.name) return false;
    if (stage.is_alone) return true;
  }
  return false;
}

/// Returns the name of the plugin without its category, such as "path".
std::string name_of(const Integrator& integrator) {
  const std::string& plugin = integrator.plugin();
  return plugin.substr(plugin.find('/') + 1);
}

uint64_t rays_of(const RenderStats& stats) {
  return std::accumulate(stats.counters.rays.begin(), stats.counters.rays.end(), uint64_t{0});
}

}  // namespace

RenderSession::RenderSession(Options options) : options_(std::move(options)) {
  status_.integrator = integrator_ = options_.integrator;
  thread_ = std::thread([this] { work(); });
}

RenderSession::~RenderSession() {
  close();
}

void RenderSession::close() {
  {
    const std::lock_guard lock(mutex_);
    is_closing_ = true;
    cancel_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

void RenderSession::say(bool is_error, std::string text) {
  {
    const std::lock_guard lock(mutex_);
    messages_.push_back({is_error, std::move(text), ++num_messages_});
    if (messages_.size() > kMaxMessages) messages_.pop_front();
  }
  notify();
}

/// Reports a warning, unless it is among the messages already: each render repeats it.
void RenderSession::warn(const std::string& text) {
  const std::string whole = "warning: " + text;
  {
    const std::lock_guard lock(mutex_);
    const bool is_known =
        std::any_of(messages_.begin(), messages_.end(),
                    [&](const Message& message) { return message.text == whole; });
    if (is_known) return;
  }
  say(false, whole);
}

void RenderSession::wait() {
  std::unique_lock lock(mutex_);
  const uint64_t last = asked_;
  changed_.wait(lock, [&] { return served_ >= last || is_closing_; });
}

void RenderSession::set_activity(Activity activity) {
  const std::lock_guard lock(mutex_);
  status_.activity = activity;
  status_.is_exact = exact_samples_.has_value();
  status_.is_paused = is_paused_;
  status_.is_denoising = denoiser_ != nullptr;
  status_.integrator = integrator_;
}

bool RenderSession::has_work() const {
  if (!scene_ || scene_->sensors().empty()) return false;
  return wants_preview_ || (!is_done_ && (!is_paused_ || is_coarse_));
}

bool RenderSession::is_still() const {
  return Clock::now() - last_change_ > kStillInterval;
}

bool RenderSession::attempt(const std::function<void()>& function) {
  try {
    function();
    return true;
  } catch (const std::exception& fault) {
    say(true, text_of(fault));
    return false;
  }
}

void RenderSession::work() {
  attempt([&] {
    context_ = std::make_unique<RenderContext>(
        RenderOptions{.threads = options_.threads,
                      .seed = options_.seed,
                      .cancel = &cancel_,
                      .progress = [this](double done) { fraction_ = done; }});
    load(options_.scene);
  });
  notify();
  while (true) {
    if (scene_ && !wants_preview_ && (!is_moving_ || is_still())) {
      attempt([&] { publish_info(); });
    }
    std::vector<Request> requests;
    {
      std::unique_lock lock(mutex_);
      may_be_ended_ = false;
      if (!exact_samples_ || is_done_) {
        served_ = taken_;
        changed_.notify_all();
      }
      // Renders only previews during a movement.
      if (is_moving_ && !wants_preview_) {
        changed_.wait_until(lock, last_change_ + kStillInterval,
                            [this] { return is_closing_ || !requests_.empty(); });
      }
      if (!has_work() && requests_.empty() && !is_closing_) {
        changed_.wait(lock, [this] { return is_closing_ || !requests_.empty(); });
      }
      if (is_closing_) break;
      requests = std::exchange(requests_, {});
      taken_ = asked_;
      // Later requests that end the render set it again.
      cancel_ = false;
    }
    try {
      if (!requests.empty()) {
        make(requests);
        notify();
        continue;
      }
      is_moving_ = is_moving_ && !is_still();
      if (wants_preview_) {
        preview();
      } else if (!is_moving_) {
        {
          // Applies changes that have arrived in the meantime first.
          const std::lock_guard lock(mutex_);
          if (!requests_.empty()) continue;
          may_be_ended_ = true;
        }
        exact_samples_ ? render_exactly() : improve();
      }
    } catch (const std::exception& fault) {
      say(true, text_of(fault));
      live_.reset();
      wants_preview_ = false;
      is_done_ = true;
      set_activity(Activity::kFailed);
    }
    notify();
  }
  attempt([&] { make_at_the_end(); });
  live_.reset();
}

/// Loads the scene. If that fails, keeps the previous one.
void RenderSession::load(const std::string& file) {
  set_activity(Activity::kLoading);
  try {
    if (!registry_) {
      registry_ = std::make_unique<PluginRegistry>(
          PluginRegistry::default_folders(options_.plugin_folders));
    }
    LoadOptions load = options_.load;
    if (file != options_.scene) load.defines.clear();
    auto editor = std::make_unique<SceneEditor>(file, load, *registry_);
    const size_t sensor = choose_sensor(*editor, file);
    auto scene = with_integrator(*editor, integrator_);
    const std::lock_guard lock(scene_mutex_);
    live_.reset();
    preview_scene_.reset();
    guide_scene_.reset();
    history_.forget();
    scene_ = std::move(scene);
    editor_ = std::move(editor);
    sensor_ = sensor;
    file_ = file;
    ++edition_;
  } catch (const std::exception& fault) {
    say(true, text_of(fault));
    if (!scene_) {
      file_ = file;  // for a later reload()
      set_activity(Activity::kFailed);
    }
    return;
  }
  if (edition_ > 1) say(false, "loaded " + file_);
  begin_anew();
  publish_info();
}

std::shared_ptr<const Scene> RenderSession::with_integrator(SceneEditor& editor,
                                                                    const std::string& name) const {
  if (name.empty()) return editor.scene();
  ObjectDescription description;
  description.tag = "integrator";
  description.type = name;
  description.where = Location{"integrator " + name};
  return editor.scene_with(description);
}

/// Returns the scene for previews. Its integrator is `path` or `volpath`, with the same number of
/// bounces, if the scene's integrator is slow to begin.
const Scene& RenderSession::preview_scene() {
  const Integrator& own = scene_->integrator();
  if (!is_slow_to_begin(own)) return *scene_;
  if (preview_scene_) return *preview_scene_;
  ObjectDescription description;
  description.tag = "integrator";
  const bool has_media = own.traces_media() && !scene_->media().empty();
  description.type = has_media ? kMediaPreviewIntegrator : kPreviewIntegrator;
  description.where = Location{"preview"};
  const std::string path = editor_->path_of(own);
  for (const char* const name : {"max_depth", "hide_emitters"}) {
    if (path.empty()) break;
    const auto value = editor_->get(path + "." + name);
    if (!value) continue;
    if (const auto* const number = std::get_if<int64_t>(&*value)) {
      description.values.push_back({name, *number, description.where});
    } else if (const auto* const flag = std::get_if<bool>(&*value)) {
      description.values.push_back({name, *flag, description.where});
    }
  }
  try {
    preview_scene_ = editor_->scene_with(description);
  } catch (const Error&) {
    preview_scene_ = scene_;  // slower, but works
  }
  return *preview_scene_;
}

/// Selects the sensor, and resizes its film, by the options.
size_t RenderSession::choose_sensor(SceneEditor& editor, const std::string& file) const {
  const std::shared_ptr<const Scene> scene = editor.scene();
  const size_t index =
      app::sensor_index(*scene, file == options_.scene ? options_.sensor : "0");
  if (options_.width <= 0 || options_.height <= 0) return index;
  const std::string film = editor.path_of(scene->sensors()[index]->film());
  if (film.empty()) throw Error(Location{file}, "the sensor has no film to resize");
  editor.set(
      {{film + ".width", int64_t{options_.width}}, {film + ".height", int64_t{options_.height}}});
  editor.update();
  return index;
}

/// Renders a preview. Its number of pixels follows from the time of the last preview.
void RenderSession::preview() {
  set_activity(Activity::kPreview);
  const double start = context_->job.seconds();
  const Rect crop = sensor().film().crop();
  double scale = kInitialScale;
  if (seconds_per_pixel_ > 0) {
    scale = std::sqrt(options_.preview_seconds / (seconds_per_pixel_ * std::max(1, crop.area())));
  }
  scale = std::clamp(scale, kMinScale, 1.);
  const auto side = [&](int pixels) { return std::max(1, static_cast<int>(pixels * scale + 0.5)); };
  const double pixels = preview_of(side(crop.width()), side(crop.height()), start);
  seconds_per_pixel_ = (context_->job.seconds() - start) / pixels;
  wants_preview_ = false;
  // Renders a full-size preview next if the first pass of the integrator takes long.
  wants_whole_preview_ = scale < 1 && is_slow_to_begin(scene_->integrator());
  if (is_paused_) set_activity(Activity::kPaused);
}

/// Renders a preview of width x height pixels with one sample each. Returns the number of pixels.
double RenderSession::preview_of(int width, int height, double start) {
  const Scene* scene = nullptr;
  {
    const std::lock_guard lock(scene_mutex_);
    scene = &preview_scene();
    if (denoiser_ && !guide_scene_) guide_scene_ = PreviewDenoiser::guides_of(*editor_);
  }
  const auto film_sensor = with_own_film(sensor(), width, height, 1, denoiser_ != nullptr);
  auto image = render_once(*scene, *film_sensor, *context_);
  if (image && denoiser_ &&
      !denoiser_->denoise(*image, *guide_scene_, *film_sensor, *context_)) {
    image.reset();
  }
  if (image) publish(*scene, std::move(*image), true, false, context_->job.seconds() - start, -1);
  return static_cast<double>(width) * height;
}

void RenderSession::improve() {
  set_activity(Activity::kRendering);
  if (std::exchange(wants_whole_preview_, false)) {
    const Rect crop = sensor().film().crop();
    preview_of(crop.width(), crop.height(), context_->job.seconds());
    return;
  }
  if (!live_) live_ = std::make_unique<LiveRender>(*scene_, sensor(), *context_);
  if (cancel_) return live_.reset();  // its preparation may be incomplete
  if (!live_->pass()) {
    if (!live_->is_whole()) live_.reset();
    return;
  }
  is_coarse_ = false;
  is_done_ = live_->samples() >= options_.most_samples;
  publish(*scene_, live_->develop(), false, is_done_, live_->seconds(), live_->rel_mse());
  if (is_done_ || is_paused_) set_activity(is_done_ ? Activity::kFinished : Activity::kPaused);
}

void RenderSession::render_exactly() {
  set_activity(Activity::kRendering);
  const auto samples = sensor().with_sample_count(*exact_samples_);
  sensor().film().set_lane(0);
  scene_->integrator().warn_of_light_left_out(*scene_, sensor(), *context_);
  auto image = render_once(*scene_, *samples, *context_);
  if (!image) return;
  is_done_ = true;
  publish(*scene_, std::move(*image), false, true, context_->job.stats().render_seconds, -1);
  set_activity(Activity::kFinished);
}

void RenderSession::publish(const Scene& scene, Image image, bool is_preview, bool is_final,
                                    double seconds, double rel_mse) {
  auto picture = std::make_shared<Picture>();
  picture->image = std::move(image);
  picture->stats = context_->job.stats();
  picture->generation = ++generation_;
  picture->edition = edition_;
  picture->crop = sensor().film().crop();
  picture->is_preview = is_preview;
  picture->is_final = is_final;
  picture->integrator = name_of(scene.integrator());
  picture->samples = picture->stats.samples;
  if (!sensor().is_surface()) picture->sensor = scene_->sensors()[sensor_];
  picture->seconds = seconds;
  picture->rel_mse = rel_mse;
  picture->rays_per_second =
      seconds > 0 ? static_cast<double>(rays_of(picture->stats)) / seconds : 0;
  report_non_finite_samples(picture->stats);
  const std::lock_guard lock(mutex_);
  picture_ = std::move(picture);
}

void RenderSession::publish_info() {
  if (info_edition_ == edition_) return;
  info_edition_ = edition_;
  const std::lock_guard scene_lock(scene_mutex_);
  auto info = std::make_shared<SceneInfo>();
  info->edition = edition_;
  info->file = file_;
  info->parameters = editor_->parameters();
  info->textured = editor_->textured_parameters();
  info->objects = editor_->objects();
  for (size_t i = 0; i < scene_->sensors().size(); ++i) {
    const std::string& id = scene_->sensors()[i]->id();
    info->sensors.push_back(id.empty() ? std::to_string(i) : id);
  }
  info->integrators = registry_->names(Category::kIntegrator);
  info->own_integrator = name_of(editor_->scene()->integrator());
  info->sensor = sensor_;
  info->sensor_path = editor_->path_of(sensor());
  info->bounds = scene_->bounds();
  info->crop = sensor().film().crop();
  info->can_undo = history_.can_undo();
  if (scene_->environment()) info->environment = editor_->path_of(*scene_->environment());
  const std::lock_guard lock(mutex_);
  info->served = taken_;
  info_ = std::move(info);
}

}  // namespace kinome::viewer
