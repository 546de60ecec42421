// The thread of a RenderSession: loads the scene, applies changes and publishes its description.

#include "session/render_session.h"

#include <algorithm>

#include "options/sensor_index.h"

namespace kinome::viewer {
namespace {

/// Time after the last change at which a movement has ended.
constexpr std::chrono::milliseconds kStillInterval{150};
constexpr size_t kMaxMessages = 200;

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
  const uint64_t last = last_requested_;
  changed_.wait(lock, [&] { return last_served_ >= last || is_closing_; });
}

void RenderSession::set_activity(Activity activity) {
  const std::lock_guard lock(mutex_);
  status_.activity = activity;
  status_.is_exact = exact_samples_.has_value();
  status_.is_paused = is_paused_;
  status_.is_denoising = denoiser_ != nullptr;
  status_.region = region_;
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
    const std::optional<std::vector<Request>> requests = take_requests();
    if (!requests) break;
    try {
      if (!requests->empty()) {
        make(*requests);
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

/// Waits until there is work or a request, and returns the requests. Returns nullopt if the session
/// is closing.
std::optional<std::vector<RenderSession::Request>> RenderSession::take_requests() {
  std::unique_lock lock(mutex_);
  may_be_ended_ = false;
  if (!exact_samples_ || is_done_) {
    last_served_ = last_taken_;
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
  if (is_closing_) return {};
  last_taken_ = last_requested_;
  // Later requests that end the render set it again.
  cancel_ = false;
  return std::exchange(requests_, {});
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
    region_.reset();
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
  info->served = last_taken_;
  info_ = std::move(info);
}

}  // namespace kinome::viewer
