#include <imgui.h>

#include <utility>

#include "handles/transform_handles.h"
#include "panels/panel.h"
#include "panels/parameters/parameter_widgets.h"

namespace kinome::viewer {
namespace {

constexpr float kRingRadiusOfLamp = 7;  ///< in pixels of the window

/// Emitters other than the environment: their parameters, and a ring in the image with which the
/// user drags each of them. The last one that was pressed has the handles of all axes. They are
/// visible while the panel is open.
class LampPanel final : public Panel {
 public:
  const char* title() const override { return "Lamps"; }

  void draw(Frame& frame) override {
    is_drawn_ = true;
    if (!frame.info) return;
    if (lamps_.empty()) return ImGui::TextDisabled("The scene has none.");
    ImGui::Checkbox("handles in the picture", &has_handles_);
    for (const Lamp& lamp : lamps_) {
      if (!ImGui::TreeNode(lamp.object.c_str())) continue;
      widgets_.draw_all(frame.session, *frame.info, {lamp.object});
      ImGui::TreePop();
    }
  }

  void draw_over_picture(Frame& frame) override {
    is_open_ = std::exchange(is_drawn_, false);  // the side bar is drawn after the picture
    if (!is_open_) return;
    widgets_.begin(frame.info);
    if (!frame.info || !frame.picture) return;
    if (info_ != frame.info || generation_ != frame.picture->generation) {
      info_ = frame.info;
      generation_ = frame.picture->generation;
      find_lamps(*frame.info);
      for (Lamp& lamp : lamps_) {
        if (lamp.placement) lamp.seen = place_on_film(*frame.picture, lamp.placement->position);
      }
    }
    handles_.hide();
    if (!has_handles_ || !frame.tabs.is_live()) return;
    ImDrawList* const list = ImGui::GetWindowDrawList();
    for (const Lamp& lamp : lamps_) {
      if (!lamp.seen) continue;
      if (lamp.object == active_) {
        handles_.draw(frame, lamp.placement->position, lamp.placement->can_turn);
        continue;
      }
      const Vec2 at = frame.view.area().to_window(*lamp.seen);
      list->AddCircle({at.x, at.y}, kRingRadiusOfLamp, IM_COL32(0, 0, 0, 255), 0, 4);
      list->AddCircle({at.x, at.y}, kRingRadiusOfLamp, IM_COL32(255, 220, 80, 255), 0, 2);
    }
  }

  bool press(Frame& frame, const PictureClick& click) override {
    if (!is_open_ || !has_handles_ || !frame.tabs.is_live() || click.button != 0) return false;
    for (const Lamp& lamp : lamps_) {
      if (lamp.object != active_ || !lamp.placement) continue;
      if (handles_.press(frame, click.film, *lamp.placement)) return true;
    }
    for (const Lamp& lamp : lamps_) {
      if (!lamp.seen) continue;
      const float distance = glm::length(*lamp.seen - click.film) * frame.view.area().scale;
      if (distance > kRingRadiusOfLamp + 2) continue;
      active_ = lamp.object;
      handles_.grab(frame, Handle::kMoveInView, click.film, *lamp.placement);
      return true;
    }
    return false;
  }
  void drag(Frame& frame, const Vec2& film) override { handles_.drag(frame, film, widgets_); }
  void release(Frame& /*frame*/) override { handles_.release(); }

 private:
  struct Lamp {
    std::string object;                  ///< path of the emitter
    std::optional<Placement> placement;  ///< nullopt if it has no position
    std::optional<Vec2> seen;            ///< position on the film; nullopt if it isn't visible
  };
  /// Collects the scene's emitters, except the environment, with their current positions.
  void find_lamps(const SceneInfo& info) {
    lamps_.clear();
    for (const SceneParameter& parameter : info.parameters) {
      const std::string object = object_of(parameter.path);
      const bool is_emitter = parameter.plugin.starts_with("emitter/");
      if (!is_emitter || object == info.environment ||
          (!lamps_.empty() && lamps_.back().object == object)) {
        continue;
      }
      Lamp lamp;
      lamp.object = object;
      // The shape has the position of an area emitter. A directional emitter has none.
      const bool is_surface = parameter.plugin.ends_with("area");
      if (parameter.plugin != "emitter/directional") {
        lamp.placement = placement_of(info, widgets_, is_surface ? object_of(object) : object);
      }
      lamps_.push_back(std::move(lamp));
    }
  }

  ParameterWidgets widgets_;
  TransformHandles handles_;
  std::shared_ptr<const SceneInfo> info_;
  uint64_t generation_ = 0;  ///< image from which lamps_ was last updated
  std::vector<Lamp> lamps_;
  std::string active_;  ///< path of the emitter that was pressed last
  bool has_handles_ = true;
  bool is_drawn_ = false;  ///< the side bar has drawn the panel since the last frame
  bool is_open_ = false;
};

}  // namespace

std::unique_ptr<Panel> make_lamp_panel() {
  return std::make_unique<LampPanel>();
}

}  // namespace kinome::viewer
