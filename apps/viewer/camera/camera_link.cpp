#include "camera/camera_link.h"

#include "camera/transforms.h"

namespace kinome::viewer {
namespace {

/// Returns a default distance to the target: that of the scene's centre.
float distance_of(const Transform& to_world, const Aabb& bounds) {
  if (bounds.empty()) return 1;
  const Vec3 origin(to_world.matrix()[3]), forward(to_world.matrix()[2]);
  const float along = glm::dot(bounds.centre() - origin, glm::normalize(forward));
  return along > 0 ? along : 0.5f * glm::length(bounds.extent());
}

}  // namespace

void CameraLink::follow(RenderSession& session, const std::shared_ptr<const SceneInfo>& info) {
  apply_pick();
  if (!info || info->served < sent_number_) return;  // older than the last edit sent
  if (info->edition == edition_ && info->sensor_path == path_) return;
  edition_ = info->edition;
  const SceneParameter* const found =
      info->sensor_path.empty() ? nullptr : info->find(info->sensor_path + ".to_world");
  const Transform* const now =
      found && found->value ? std::get_if<Transform>(&*found->value) : nullptr;
  if (!now) return path_.clear();
  is_orthographic_ = found->plugin == "sensor/orthographic";
  const bool is_other = info->sensor_path != path_;
  path_ = info->sensor_path;
  if (!is_other && are_alike(now->matrix(), sent_.matrix())) return;
  sent_ = *now;
  const float distance = is_other ? distance_of(*now, info->bounds) : controls_.distance();
  if (!is_other) return controls_.take(*now, distance);
  controls_.set_home(*now, distance);
  home_ = controls_.to_world();
  is_home_written_ = !found->is_edited;
  const Rect& crop = info->crop;
  const Vec2 middle(0.5f * static_cast<float>(crop.x0 + crop.x1),
                    0.5f * static_cast<float>(crop.y0 + crop.y1));
  aiming_ = session.ask_pick(middle);
  apply_pick();
}

/// Moves the target to the surface in the middle of the image, once the answer has arrived.
void CameraLink::apply_pick() {
  if (!aiming_ || !aiming_->is_there()) return;
  const std::optional<Pick> pick = aiming_->pick();
  aiming_.reset();
  // Ignores the answer if the camera has moved in the meantime.
  if (!pick || controls_.to_world().matrix() != home_.matrix()) return;
  const float distance = glm::dot(pick->point - controls_.origin(), controls_.forward());
  if (!(distance > 0)) return;
  controls_.set_home(controls_.home(), distance);
  home_ = controls_.to_world();
}

void CameraLink::send(RenderSession& session) {
  if (!can_move()) return;
  sent_ = controls_.to_world();
  // At its home position, keeps the transform as written in the scene file.
  const bool is_as_written = is_home_written_ && sent_.matrix() == home_.matrix();
  const EditedValue value = is_as_written ? EditedValue(AsWritten{}) : Placed{sent_};
  sent_number_ = session.set({{path_ + ".to_world", value}}, true, false);
}

}  // namespace kinome::viewer
