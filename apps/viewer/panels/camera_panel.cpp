#include <imgui.h>

#include "panels/panel.h"
#include "panels/widgets.h"

namespace kinome::viewer {
namespace {

/// Position of the camera, reset, <lookat> for the clipboard, and focus of a thin lens.
class CameraPanel final : public Panel {
 public:
  const char* title() const override { return "Camera"; }

  void draw(Frame& frame) override {
    CameraLink& camera = frame.camera;
    if (frame.info && frame.info->sensors.size() > 1) {
      const std::vector<std::string>& sensors = frame.info->sensors;
      const auto chosen = choose("sensor", sensors[frame.info->sensor], sensors);
      if (chosen) frame.session.set_sensor(*chosen);
    }
    if (!camera.can_move()) return ImGui::TextDisabled("This sensor can't be moved.");
    const Vec3 origin = camera.controls().origin(), target = camera.controls().target();
    ImGui::Text("origin  %.4g, %.4g, %.4g", origin.x, origin.y, origin.z);
    ImGui::Text("target  %.4g, %.4g, %.4g", target.x, target.y, target.z);
    if (ImGui::Button("Reset")) {
      camera.controls().reset();
      camera.send(frame.session);
    }
    ImGui::SameLine();
    if (ImGui::Button("Copy <lookat>")) {
      ImGui::SetClipboardText(camera.controls().lookat().c_str());
      frame.session.say(false, "copied " + camera.controls().lookat());
    }
    ImGui::TextDisabled(
        "drag: orbit   Shift+drag: pan   wheel: dolly\n"
        "right drag: look   W A S D Q E: fly\n"
        "Ctrl+click: focus   Ctrl+wheel, Ctrl+drag: zoom   F: fit\n"
        "Ctrl+Shift+drag: render only a region");
  }

  /// With Ctrl, focuses a thin lens on the surface under the mouse.
  bool click(Frame& frame, const PictureClick& click) override {
    if (!click.ctrl || click.button != 0) return false;
    const std::string path = frame.info ? frame.info->sensor_path + ".focus_distance" : "";
    if (!frame.info || !frame.info->find(path)) {
      frame.session.say(true, "this sensor has no focus");
      return true;
    }
    focus_ = frame.session.ask_pick(click.film);
    return true;
  }

  void draw_over_picture(Frame& frame) override {
    if (!focus_ || !focus_->is_there()) return;
    const std::optional<Pick> pick = focus_->pick();
    focus_.reset();
    if (!pick || !frame.info) return;
    // The plane in focus is perpendicular to the viewing direction.
    const CameraControls& camera = frame.camera.controls();
    const float depth = glm::dot(pick->point - camera.origin(), camera.forward());
    frame.session.set({{frame.info->sensor_path + ".focus_distance", double{depth}}});
  }

 private:
  std::shared_ptr<const PickAnswer> focus_;  ///< surface to focus on; nullptr if none is requested
};

}  // namespace

std::unique_ptr<Panel> make_camera_panel() {
  return std::make_unique<CameraPanel>();
}

}  // namespace kinome::viewer
