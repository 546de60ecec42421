#include "panels/environment_panel.h"

#include <imgui.h>

#include <glm/gtc/matrix_transform.hpp>
#include <set>

namespace kinome::viewer {
namespace {

bool is_environment(const std::string& plugin) {
  static const std::set<std::string> all = {"emitter/envmap", "emitter/constant",
                                            "emitter/sunsky", "emitter/sky",
                                            "emitter/sun",    "emitter/timed_sunsky"};
  return all.contains(plugin);
}

}  // namespace

void EnvironmentPanel::draw(Frame& frame) {
  widgets_.begin(frame.info);
  if (!frame.info) return;
  std::vector<std::string> objects;
  for (const SceneParameter& parameter : frame.info->parameters) {
    if (!is_environment(parameter.plugin)) continue;
    const std::string object = object_of(parameter.path);
    if (objects.empty() || objects.back() != object) objects.push_back(object);
  }
  if (objects.empty()) return ImGui::TextDisabled("The scene has none.");
  for (const std::string& object : objects) {
    ImGui::PushID(object.c_str());
    draw_turn(frame, object);
    widgets_.draw_all(frame.session, *frame.info, {object});
    ImGui::PopID();
  }
}

/// Around the axis that is up.
void EnvironmentPanel::draw_turn(Frame& frame, const std::string& object) {
  const std::string path = object + ".to_world";
  const SceneParameter* const parameter = frame.info->find(path);
  if (!parameter) return;
  const auto value = widgets_.value(*parameter);
  const auto* const now = value ? std::get_if<Transform>(&*value) : nullptr;
  if (!now) return;
  Turn& turn = turns_[path];
  // Set by someone else.
  if (turn.now.matrix() != now->matrix()) turn = {*now, *now, 0};
  if (!ImGui::SliderFloat("turn", &turn.degrees, -180, 180, "%.0f degrees")) return;
  const Mat4 rotation =
      glm::rotate(Mat4(1.f), glm::radians(turn.degrees), frame.camera.controls().up());
  turn.now = Transform(rotation * turn.base.matrix());
  widgets_.set(frame.session, path, turn.now, true);
}

}  // namespace kinome::viewer
