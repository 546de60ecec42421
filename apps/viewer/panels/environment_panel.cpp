#include <imgui.h>

#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "panels/panel.h"
#include "panels/parameters/parameter_widgets.h"

namespace kinome::viewer {
namespace {

/// The environment emitter: its rotation and parameters.
class EnvironmentPanel final : public Panel {
 public:
  const char* title() const override { return "Environment"; }

  void draw(Frame& frame) override {
    widgets_.begin(frame.info);
    if (!frame.info) return;
    if (frame.info->environment.empty()) return ImGui::TextDisabled("The scene has none.");
    const std::string& object = frame.info->environment;
    ImGui::PushID(object.c_str());
    draw_turn(frame, object);
    widgets_.draw_all(frame.session, *frame.info, {object});
    ImGui::PopID();
  }

 private:
  /// Draws a slider that turns the environment around the camera's vertical axis.
  void draw_turn(Frame& frame, const std::string& object) {
    const std::string path = object + ".to_world";
    const SceneParameter* const parameter = frame.info->find(path);
    if (!parameter) return;
    const auto value = widgets_.value(*parameter);
    const auto* const now = value ? std::get_if<Transform>(&*value) : nullptr;
    if (!now) return;
    Turn& turn = turns_[path];
    // Starts again from a value that was set elsewhere.
    if (turn.now.matrix() != now->matrix()) turn = {*now, *now, 0};
    if (!ImGui::SliderFloat("turn", &turn.degrees, -180, 180, "%.0f degrees")) return;
    const Mat4 rotation =
        glm::rotate(Mat4(1.f), glm::radians(turn.degrees), frame.camera.controls().up());
    turn.now = Transform(rotation * turn.base.matrix());
    widgets_.set(frame.session, path, turn.now, true);
  }

  ParameterWidgets widgets_;
  /// Rotation of an object.
  struct Turn {
    Transform base;  ///< at 0 degrees
    Transform now;
    float degrees = 0;
  };
  std::map<std::string, Turn> turns_;
};

}  // namespace

std::unique_ptr<Panel> make_environment_panel() {
  return std::make_unique<EnvironmentPanel>();
}

}  // namespace kinome::viewer
