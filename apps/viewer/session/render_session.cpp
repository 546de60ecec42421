#include "session/render_session.h"

#include <algorithm>

#include "session/worker.h"

namespace kinome::viewer {

namespace {

template <class T>
const T* with_path(const std::vector<T>& all, const std::string& path) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const T& one) { return one.path == path; });
  return found == all.end() ? nullptr : &*found;
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

RenderSession::RenderSession(Options options)
    : worker_(std::make_unique<Worker>(std::move(options))) {}
RenderSession::~RenderSession() = default;

PicturePointer RenderSession::picture() const {
  const std::lock_guard lock(worker_->mutex);
  return worker_->shown.picture;
}
std::shared_ptr<const SceneInfo> RenderSession::info() const {
  const std::lock_guard lock(worker_->mutex);
  return worker_->shown.info;
}
Status RenderSession::status() const {
  const std::lock_guard lock(worker_->mutex);
  Status status = worker_->shown.status;
  status.fraction = worker_->fraction;
  status.integrator = worker_->shown.integrator;
  return status;
}
std::vector<Message> RenderSession::messages(uint64_t known) const {
  const std::lock_guard lock(worker_->mutex);
  const auto& all = worker_->shown.messages;
  const auto first = std::find_if(all.begin(), all.end(),
                                  [&](const Message& message) { return message.number > known; });
  return {first, all.end()};
}
void RenderSession::say(bool is_error, std::string text) {
  worker_->say(is_error, std::move(text));
}

uint64_t RenderSession::set(Edits edits, bool is_moving, bool is_undoable) {
  if (edits.empty()) return 0;
  return worker_->request(
      true,
      Settings{{{std::move(edits), is_undoable}}, is_moving, std::chrono::steady_clock::now()});
}
void RenderSession::undo() {
  worker_->request(true, Undo{});
}
void RenderSession::set_integrator(std::string name) {
  worker_->request(true, UseIntegrator{std::move(name)});
}
void RenderSession::set_sensor(size_t index) {
  worker_->request(true, UseSensor{index});
}
void RenderSession::set_paused(bool is_paused) {
  worker_->request(false, Pause{is_paused});
}
void RenderSession::restart() {
  worker_->request(true, Restart{});
}
void RenderSession::render(uint32_t samples) {
  worker_->request(true, RenderExactly{std::max(1u, samples)});
}
void RenderSession::reload() {
  worker_->request(true, Reload{});
}
void RenderSession::run(Task task) {
  worker_->request(false, RunTask{std::move(task)});
}
void RenderSession::save(std::string path) {
  ++worker_->saves_to_come;
  worker_->request(false, RunTask{[this, path = std::move(path)](const Access& access) {
                                    access.editor.save(path);
                                    say(false, "saved " + path);
                                  },
                                  true});
}
bool RenderSession::is_to_save() const {
  return worker_->saves_to_come > 0;
}
void RenderSession::close() {
  worker_->close();
}
void RenderSession::wait() const {
  worker_->wait();
}
std::optional<Pick> RenderSession::pick(const Vec2& film_position) const {
  return worker_->pick(film_position);
}
std::shared_ptr<const PickAnswer> RenderSession::ask_pick(const Vec2& film_position) const {
  return worker_->ask_pick(film_position);
}

}  // namespace kinome::viewer
