#include "window/picture_mouse.h"

#include <imgui.h>

#include <cmath>
#include <utility>

namespace kinome::viewer {
namespace {

/// Maximum movement of the mouse during a click [pixels].
constexpr float kMaxClickMovement = 4;
constexpr float kWheelZoom = 1.25f;
constexpr float kWheelDolly = 1.1f;
/// Angles for a drag by the height of the image [rad].
constexpr float kOrbitSpeed = kPi, kLookSpeed = 1;
/// Height of the view divided by the target's distance, for a field of view of 40 degrees.
constexpr float kViewHeight = 0.73f;

Vec2 mouse_position() {
  const ImVec2 position = ImGui::GetIO().MousePos;
  return {position.x, position.y};
}

PictureClick click_at(const Frame& frame, const Vec2& position, int button) {
  const ImGuiIO& io = ImGui::GetIO();
  return {frame.view.area().to_film(position), button, io.KeyAlt, io.KeyCtrl, io.KeyShift};
}

}  // namespace

void PictureMouse::update(Frame& frame, const std::vector<std::unique_ptr<Panel>>& panels) {
  take_selection(frame);
  const bool is_over = ImGui::IsWindowHovered() && !ImGui::IsAnyItemHovered();
  for (int button = 0; button < 3 && button_ < 0; ++button) {
    if (is_over && ImGui::IsMouseClicked(button)) press(frame, panels, button);
  }
  if (button_ >= 0) {
    is_drag_ = is_drag_ || glm::length(mouse_position() - pressed_at_) > kMaxClickMovement;
    if (is_drag_) drag(frame);
    if (!ImGui::IsMouseDown(button_)) release(frame, panels);
  }
  if (is_over && ImGui::GetIO().MouseWheel != 0) turn_wheel(frame);
}

void PictureMouse::press(Frame& frame, const std::vector<std::unique_ptr<Panel>>& panels,
                         int button) {
  button_ = button;
  is_drag_ = false;
  drag_panel_ = nullptr;
  pressed_at_ = mouse_position();
  pressed_ = click_at(frame, pressed_at_, button);
  for (const auto& panel : panels) {
    if (panel->press(frame, pressed_)) {
      drag_panel_ = panel.get();
      return;
    }
  }
}

void PictureMouse::release(Frame& frame, const std::vector<std::unique_ptr<Panel>>& panels) {
  button_ = -1;
  if (Panel* const panel = std::exchange(drag_panel_, nullptr)) return panel->release(frame);
  if (is_drag_ || !frame.tabs.is_live() || !frame.view.area().shows(pressed_.film)) return;
  for (const auto& panel : panels) {
    if (panel->click(frame, pressed_)) return;
  }
  if (pressed_.button == 0) selecting_ = frame.session.ask_pick(pressed_.film);
}

void PictureMouse::take_selection(Frame& frame) {
  if (!selecting_ || !selecting_->is_there()) return;
  const auto& pick = selecting_->pick();
  frame.selection = pick ? std::make_shared<const Pick>(*pick) : nullptr;
  selecting_.reset();
}

void PictureMouse::drag(Frame& frame) {
  const ImGuiIO& io = ImGui::GetIO();
  const Vec2 moved(io.MouseDelta.x, io.MouseDelta.y);
  if (moved == Vec2(0.f)) return;
  if (drag_panel_) return drag_panel_->drag(frame, frame.view.area().to_film(mouse_position()));
  // A kept image can't show the movement of the camera.
  if (io.KeyCtrl || !frame.tabs.is_live()) return frame.view.move(moved);
  if (!frame.camera.can_move()) return;
  CameraControls& camera = frame.camera.controls();
  const PictureArea& area = frame.view.area();
  const float height = area.scale * static_cast<float>(std::max(1, area.crop.height()));
  const Vec2 share = moved / height;
  if (button_ == 2 || (button_ == 0 && io.KeyShift)) {
    // Objects at the target's distance follow the mouse, for a field of view of about 40 degrees.
    const float length = kViewHeight * camera.distance();
    camera.move(-share.x * length, share.y * length, 0);
  } else if (button_ == 1) {
    camera.look(share.x * kLookSpeed, -share.y * kLookSpeed);
  } else {
    camera.orbit(-share.x * kOrbitSpeed, share.y * kOrbitSpeed);
  }
  frame.camera.send(frame.session);
}

void PictureMouse::turn_wheel(Frame& frame) {
  const float steps = ImGui::GetIO().MouseWheel;
  if (ImGui::GetIO().KeyCtrl || !frame.tabs.is_live()) {
    return frame.view.zoom(std::pow(kWheelZoom, steps), mouse_position());
  }
  if (!frame.camera.can_move()) return;
  frame.camera.controls().dolly(std::pow(kWheelDolly, -steps), frame.camera.is_orthographic());
  frame.camera.send(frame.session);
}

}  // namespace kinome::viewer
