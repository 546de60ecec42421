// Queries of a RenderSession's scene.

#include <algorithm>

#include "session/names.h"
#include "session/render_session.h"

namespace kinome::viewer {
namespace {

void add_materials(const Object& object, const SceneEditor& editor,
                   std::vector<std::string>& paths) {
  const std::string path = editor.path_of(object);
  if (!path.empty() && std::find(paths.begin(), paths.end(), path) == paths.end()) {
    paths.push_back(path);
  }
  for (const auto& part : object.nested()) add_materials(*part, editor, paths);
}

}  // namespace

void RenderSession::publish_info() {
  if (info_edition_ == edition_) return;
  info_edition_ = edition_;
  const std::lock_guard scene_lock(scene_mutex_);
  auto info = std::make_shared<SceneInfo>();
  info->edition = edition_;
  info->file = options_.scene;
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
  info->film_path = editor_->path_of(sensor().film());
  info->bounds = scene_->bounds();
  info->crop = sensor().film().crop();
  info->can_undo = history_.can_undo();
  if (scene_->environment()) info->environment = editor_->path_of(*scene_->environment());
  const std::lock_guard lock(mutex_);
  info->served = taken_;
  info_ = std::move(info);
}

std::optional<Pick> RenderSession::pick(const Vec2& film_position) const {
  const std::lock_guard lock(scene_mutex_);
  return picked(film_position);
}

/// The caller must hold scene_mutex_.
std::optional<Pick> RenderSession::picked(const Vec2& film_position) const {
  if (!scene_ || scene_->sensors().empty()) return std::nullopt;
  RayHit hit;
  hit.ray = sensor().sample_ray(film_position, Vec2(0.5f));
  RenderCounters counters;
  scene_->intersect({&hit, 1}, Coherence::kIncoherent, counters);
  if (!hit.hit.valid()) return std::nullopt;
  const SurfaceInteraction si = scene_->interaction(hit);
  Pick pick;
  pick.origin = hit.ray.o;
  pick.direction = hit.ray.d;
  pick.point = si.p;
  pick.normal = si.frame.n;
  pick.distance = hit.ray.tmax;
  pick.shape = editor_->path_of(*si.shape);
  add_materials(si.shape->bsdf(), *editor_, pick.materials);
  if (si.shape->emitter()) pick.emitter = editor_->path_of(*si.shape->emitter());
  return pick;
}

}  // namespace kinome::viewer
