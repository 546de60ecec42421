// Functions of a RenderSession for all threads, and the processing of their requests.

#include "session/render_session.h"

#include <algorithm>
#include <utility>

namespace kinome::viewer {
namespace {

template <class T>
const T* with_path(const std::vector<T>& all, const std::string& path) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const T& one) { return one.path == path; });
  return found == all.end() ? nullptr : &*found;
}

/// Returns the common pixels of two rectangles, or nullopt if there are none.
std::optional<Rect> overlap(const Rect& a, const Rect& b) {
  const Rect both(std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1),
                  std::min(a.y1, b.y1));
  return both.width() > 0 && both.height() > 0 ? std::optional(both) : std::nullopt;
}

}  // namespace

const SceneParameter* SceneInfo::find(const std::string& path) const {
  return with_path(parameters, path);
}
const SceneParameter* SceneInfo::find_textured(const std::string& path) const {
  return with_path(textured, path);
}
const SceneObject* SceneInfo::find_object(const std::string& path) const {
  return with_path(objects, path);
}

PicturePointer RenderSession::picture() const {
  const std::lock_guard lock(mutex_);
  return picture_;
}
std::shared_ptr<const SceneInfo> RenderSession::info() const {
  const std::lock_guard lock(mutex_);
  return info_;
}
Status RenderSession::status() const {
  const std::lock_guard lock(mutex_);
  Status status = status_;
  status.fraction = fraction_;
  return status;
}
std::vector<Message> RenderSession::messages(uint64_t known) const {
  const std::lock_guard lock(mutex_);
  const auto first = std::find_if(messages_.begin(), messages_.end(),
                                  [&](const Message& message) { return message.number > known; });
  return {first, messages_.end()};
}

uint64_t RenderSession::request(bool ends_render, Request asked) {
  const std::lock_guard lock(mutex_);
  const bool is_first = requests_.empty();
  const bool is_undo = asked.kind == Request::Kind::kUndo;
  if (asked.kind == Request::Kind::kSet && !is_first && requests_.back().kind == asked.kind) {
    Request& before = requests_.back();
    for (Change& change : asked.changes) add_change(before.changes, std::move(change));
    before.is_moving = asked.is_moving;
    before.when = asked.when;
  } else {
    requests_.push_back(std::move(asked));
  }
  ++last_requested_;
  // An undo has no effect if the history is empty and no waiting request can add to it. Then the
  // render continues.
  const bool has_no_effect = is_undo && is_first && !can_undo_;
  if (ends_render && may_be_ended_ && !has_no_effect) cancel_ = true;
  changed_.notify_all();
  return last_requested_;
}

uint64_t RenderSession::set(Edits edits, bool is_moving, bool is_undoable) {
  if (edits.empty()) return 0;
  return request(true, {.kind = Request::Kind::kSet,
                        .serve = {},
                        .changes = {{std::move(edits), is_undoable}},
                        .is_moving = is_moving,
                        .when = Clock::now()});
}

void RenderSession::undo() {
  request(true, {Request::Kind::kUndo, [this] {
                   if (!history_.can_undo()) return;
                   const bool is_new = attempt([this] {
                     const std::lock_guard lock(scene_mutex_);
                     history_.undo(*editor_);
                   });
                   if (is_new) take_edited_scene();
                 }});
}

void RenderSession::set_integrator(std::string name) {
  request(true, {Request::Kind::kOther, [this, name = std::move(name)] {
                   const bool is_new = attempt([&] {
                     const std::lock_guard lock(scene_mutex_);
                     scene_ = with_integrator(*editor_, name);
                     integrator_ = name;
                     preview_scene_.reset();
                     guide_scene_.reset();
                   });
                   if (is_new) begin_anew();
                 }});
}

void RenderSession::set_sensor(size_t index) {
  request(true, {Request::Kind::kOther, [this, index] {
                   if (index >= scene_->sensors().size()) return;
                   {
                     const std::lock_guard lock(scene_mutex_);
                     sensor_ = index;
                   }
                   region_.reset();
                   info_edition_ = ~uint64_t{0};
                   begin_anew();
                 }});
}

/// True if the current pass can end at once without loss. Its finished tiles then improve the
/// image. render() and the first pass would begin again.
bool RenderSession::can_end_pass() const {
  const std::lock_guard lock(mutex_);
  return !status_.is_exact && picture_ && LiveRender::survives_interruption(*picture_);
}

void RenderSession::set_paused(bool is_paused) {
  request(is_paused && can_end_pass(),
          {Request::Kind::kOther, [this, is_paused] { is_paused_ = is_paused; }});
}

void RenderSession::set_denoising(bool is_denoising) {
  request(false, {Request::Kind::kOther, [this, is_denoising] {
                    denoiser_.reset();
                    if (!is_denoising) return;
                    attempt([this] {
                      denoiser_ = std::make_unique<const PreviewDenoiser>(options_.threads);
                    });
                  }});
}

void RenderSession::set_region(std::optional<Rect> region) {
  request(can_end_pass(), {Request::Kind::kOther, [this, region] {
                   const Rect& crop = sensor().film().crop();
                   const auto seen = region ? overlap(*region, crop) : std::nullopt;
                   if (region && !seen) throw Error("the region is outside of the image");
                   region_ = seen;
                   // Another part of a finished image may still improve.
                   if (!exact_samples_) is_done_ = false;
                 }});
}

void RenderSession::restart() {
  request(true, {Request::Kind::kOther, [this] { begin_anew(); }});
}

void RenderSession::reload() {
  request(true, {Request::Kind::kReload, [this] { load(file_); }});
}

void RenderSession::open(std::string scene) {
  request(true, {Request::Kind::kReload, [this, scene = std::move(scene)] { load(scene); }});
}

void RenderSession::render(uint32_t samples) {
  request(true, {Request::Kind::kOther, [this, samples] {
                   exact_samples_ = std::max(1u, samples);
                   is_done_ = false;
                   is_paused_ = false;
                   live_.reset();  // render_exactly() overwrites its film
                 }});
}

void RenderSession::run_now(const Task& task) {
  attempt([&] {
    const std::lock_guard lock(scene_mutex_);
    task({*editor_, *scene_, sensor(), context_->scheduler.threads()});
  });
}

void RenderSession::run(Task task) {
  request(false, {Request::Kind::kTask, [this, task = std::move(task)] { run_now(task); },
                  [this] { say(true, "there is no scene"); }});
}

void RenderSession::save(std::string path) {
  ++saves_to_come_;
  const auto serve = [this, path = std::move(path)] {
    run_now([&](const Access& access) {
      access.editor.save(path);
      say(false, "saved " + path);
    });
    --saves_to_come_;
  };
  request(false, {Request::Kind::kSave, serve, [this] {
                    say(true, "there is no scene");
                    --saves_to_come_;
                  }});
}

/// Does the pending saves, and the changes requested before them.
void RenderSession::make_at_the_end() {
  std::vector<Request> requests;
  {
    const std::lock_guard lock(mutex_);
    requests = std::exchange(requests_, {});
  }
  while (!requests.empty() && requests.back().kind != Request::Kind::kSave) requests.pop_back();
  std::erase_if(requests, [](const Request& one) { return one.kind == Request::Kind::kTask; });
  make(requests);
}

/// Processes requests in order.
void RenderSession::make(const std::vector<Request>& requests) {
  // Keeps the scene alive, because the unfinished render refers to it.
  const auto before = scene_;
  for (const Request& request : requests) {
    if (!scene_ && request.kind != Request::Kind::kReload) {
      if (request.refuse) request.refuse();
      continue;
    }
    request.kind == Request::Kind::kSet ? make_changes(request) : request.serve();
    can_undo_ = history_.can_undo();
  }
  if (!scene_) return;
  if (has_finished_tiles_ && live_) publish_live();
  set_activity(is_done_     ? Activity::kFinished
               : is_paused_ ? Activity::kPaused
                            : Activity::kRendering);
}

void RenderSession::make_changes(const Request& settings) {
  bool is_new = false;
  {
    const std::lock_guard lock(scene_mutex_);
    is_new = history_.make(*editor_, settings.changes,
                           [this](const std::string& text) { say(true, text); });
  }
  if (is_new) {
    take_edited_scene();
  } else {
    info_edition_ = ~uint64_t{0};  // publishes the unchanged values, so that panels show them again
  }
  is_moving_ = settings.is_moving;
  last_change_ = settings.when;
}

void RenderSession::take_edited_scene() {
  {
    const std::lock_guard lock(scene_mutex_);
    scene_ = with_integrator(*editor_, integrator_);
    preview_scene_.reset();
    guide_scene_.reset();
    ++edition_;
  }
  begin_anew();
}

/// Restarts the image, for instance after a change of the scene.
void RenderSession::begin_anew() {
  live_.reset();
  exact_samples_.reset();
  is_done_ = false;
  wants_preview_ = is_coarse_ = true;
}

void RenderSession::report_non_finite_samples(const RenderStats& stats) {
  if (stats.non_finite_samples == 0 || reported_edition_ == edition_) return;
  reported_edition_ = edition_;
  say(true, "dropped samples that were not finite: " + std::to_string(stats.non_finite_samples) +
                " so far");
}

}  // namespace kinome::viewer
