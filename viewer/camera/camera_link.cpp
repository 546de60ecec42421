#include "camera/camera_link.h"

namespace kinome::viewer {
namespace {

/// Of a target that nothing tells: where the scene's middle is.
float distance_of(const Transform& to_world, const Aabb& bounds) {
  if (bounds.empty()) return 1;
  const Vec3 origin(to_world.matrix()[3]), forward(to_world.matrix()[2]);
  const float along = glm::dot(bounds.centre() - origin, glm::normalize(forward));
  return along > 0 ? along : 0.5f * glm::length(bounds.extent());
}

}  // namespace

void CameraLink::follow(const RenderSession& session,
                        const std::shared_ptr<const SceneInfo>& info) {
  if (!info || info->served < sent_number_) return;  // of before what was sent
  if (info->edition == edition_ && info->sensor_path == path_) return;
  edition_ = info->edition;
  crop_ = info->crop;
  const SceneParameter* const found =
      info->sensor_path.empty() ? nullptr : info->find(info->sensor_path + ".to_world");
  const Transform* const now =
      found && found->value ? std::get_if<Transform>(&*found->value) : nullptr;
  if (!now) return path_.clear();
  is_orthographic_ = found->plugin == "sensor/orthographic";
  const bool is_other = info->sensor_path != path_;
  path_ = info->sensor_path;
  if (!is_other && now->matrix() == sent_.matrix()) return;
  sent_ = *now;
  const float distance = is_other ? distance_of(*now, info->bounds) : controls_.distance();
  if (!is_other) return controls_.take(*now, distance);
  controls_.take_home(*now, distance);
  aim(session);
  controls_.take_home(*now, controls_.distance());
}

void CameraLink::send(RenderSession& session) {
  if (!can_move()) return;
  sent_ = controls_.to_world();
  sent_number_ = session.set({{path_ + ".to_world", sent_}}, true, false);
}

void CameraLink::aim(const RenderSession& session) {
  const Vec2 middle(0.5f * static_cast<float>(crop_.x0 + crop_.x1),
                    0.5f * static_cast<float>(crop_.y0 + crop_.y1));
  const auto pick = session.pick(middle);
  if (pick) controls_.set_distance(glm::dot(pick->point - controls_.origin(), controls_.forward()));
}

}  // namespace kinome::viewer
