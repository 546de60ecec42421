// Requests to a RenderSession, and their processing by its thread.

#include <algorithm>
#include <utility>

#include "session/worker.h"

namespace kinome::viewer {

uint64_t RenderSession::Worker::request(bool ends_render, Request asked) {
  const std::lock_guard lock(mutex);
  const bool is_first = requests_.empty();
  const bool is_undo = std::holds_alternative<Undo>(asked);
  auto* const settings = std::get_if<Settings>(&asked);
  auto* const before = requests_.empty() ? nullptr : std::get_if<Settings>(&requests_.back());
  if (settings && before) {
    for (Change& change : settings->changes) add_change(before->changes, std::move(change));
    before->is_moving = settings->is_moving;
    before->when = settings->when;
  } else {
    requests_.push_back(std::move(asked));
  }
  ++asked_;
  // An undo has no effect if the history is empty and no waiting request can add to it. Then the
  // render continues.
  const bool is_in_vain = is_undo && is_first && !can_undo_;
  if (ends_render && may_be_ended_ && !is_in_vain) cancel_ = true;
  changed_.notify_all();
  return asked_;
}

/// Does the pending saves, and the changes requested before them.
void RenderSession::Worker::make_at_the_end() {
  std::vector<Request> requests;
  {
    const std::lock_guard lock(mutex);
    requests = std::exchange(requests_, {});
  }
  const auto is_save = [](const Request& request) {
    const auto* const run = std::get_if<RunTask>(&request);
    return run && run->is_save;
  };
  while (!requests.empty() && !is_save(requests.back())) requests.pop_back();
  std::erase_if(requests, [&](const Request& request) {
    return std::holds_alternative<RunTask>(request) && !is_save(request);
  });
  make(std::move(requests));
}

/// Processes requests in order.
void RenderSession::Worker::make(std::vector<Request> requests) {
  // Keeps the scene alive, because the unfinished render refers to it.
  const auto before = scene_;
  for (Request& request : requests) {
    if (!scene_ && !std::holds_alternative<Reload>(request)) {
      if (std::holds_alternative<RunTask>(request)) say(true, "there is no scene");
      if (const auto* run = std::get_if<RunTask>(&request); run && run->is_save) --saves_to_come;
      if (const auto* ask = std::get_if<AskPick>(&request)) ask->answer->give(std::nullopt);
      continue;
    }
    std::visit([this](auto& asked) { serve(asked); }, request);
    can_undo_ = history_.can_undo();
  }
  if (!scene_) return;
  set_activity(is_done_     ? Activity::kFinished
               : is_paused_ ? Activity::kPaused
                            : Activity::kRendering);
}

void RenderSession::Worker::serve(Settings& settings) {
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

void RenderSession::Worker::serve(Undo&) {
  if (!history_.can_undo()) return;
  bool is_new = false;
  {
    const std::lock_guard lock(scene_mutex_);
    is_new = history_.undo(*editor_, [this](const std::string& text) { say(true, text); });
  }
  if (is_new) take_edited_scene();
}

void RenderSession::Worker::take_edited_scene() {
  {
    const std::lock_guard lock(scene_mutex_);
    scene_ = with_integrator(*editor_, integrator_);
    preview_scene_.reset();
    ++edition_;
  }
  begin_anew();
}

void RenderSession::Worker::serve(UseIntegrator& use) {
  try {
    const std::lock_guard lock(scene_mutex_);
    scene_ = with_integrator(*editor_, use.name);
    integrator_ = use.name;
    preview_scene_.reset();
  } catch (const std::exception& fault) {
    return say(true, text_of(fault));
  }
  begin_anew();
}

void RenderSession::Worker::serve(UseSensor& use) {
  if (use.index >= scene_->sensors().size()) return;
  {
    const std::lock_guard lock(scene_mutex_);
    sensor_ = use.index;
  }
  info_edition_ = ~uint64_t{0};
  begin_anew();
}

void RenderSession::Worker::serve(RenderExactly& exactly) {
  exact_samples_ = exactly.samples;
  is_done_ = false;
  is_paused_ = false;
  live_.reset();  // render_exactly() overwrites its film
}

void RenderSession::Worker::serve(RunTask& run) {
  try {
    const std::lock_guard lock(scene_mutex_);
    run.task({*editor_, *scene_, sensor(), context_->threads()});
  } catch (const std::exception& fault) {
    say(true, text_of(fault));
  }
  if (run.is_save) --saves_to_come;
}

void RenderSession::Worker::serve(AskPick& ask) {
  const std::lock_guard lock(scene_mutex_);
  ask.answer->give(picked(ask.film_position));
}

/// Restarts the image, for instance after a change of the scene.
void RenderSession::Worker::begin_anew() {
  live_.reset();
  exact_samples_.reset();
  is_done_ = !options_.is_live;
  wants_preview_ = is_coarse_ = options_.is_live;
}

}  // namespace kinome::viewer
