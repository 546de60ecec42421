#include <imgui.h>

#include <cmath>
#include <utility>

#include "panels/panel.h"
#include "panels/parameter_widgets.h"

namespace kinome::viewer {
namespace {

constexpr float kHandleRadius = 7;  ///< in pixels of the window

/// Emitters other than the environment: their parameters, and handles in the image with which the
/// user drags them. The handles are visible while the panel is open.
class LampPanel final : public Panel {
 public:
  const char* title() const override { return "Lamps"; }

  void draw(Frame& frame) override {
    is_drawn_ = true;
    if (!frame.info) return;
    if (lamps_.empty()) return ImGui::TextDisabled("The scene has none.");
    ImGui::Checkbox("handles in the picture, to be dragged", &has_handles_);
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
        if (!lamp.path.empty()) lamp.seen = place_on_film(*frame.picture, lamp.place);
      }
    }
    if (!has_handles_) return;
    ImDrawList* const list = ImGui::GetWindowDrawList();
    for (const Lamp& lamp : lamps_) {
      if (!lamp.seen) continue;
      const Vec2 at = frame.view.area().to_window(*lamp.seen);
      list->AddCircle({at.x, at.y}, kHandleRadius, IM_COL32(0, 0, 0, 255), 0, 4);
      list->AddCircle({at.x, at.y}, kHandleRadius, IM_COL32(255, 220, 80, 255), 0, 2);
    }
  }

  bool press(Frame& frame, const PictureClick& click) override {
    if (!is_open_ || !has_handles_ || click.button != 0) return false;
    for (size_t i = 0; i < lamps_.size(); ++i) {
      if (!lamps_[i].seen) continue;
      const float distance = glm::length(*lamps_[i].seen - click.film) * frame.view.area().scale;
      if (distance > kHandleRadius + 2) continue;
      dragged_ = i;
      grabbed_ = lamps_[i].place;
      return true;
    }
    return false;
  }

  /// Moves the emitter in the plane through its old position, perpendicular to the viewing
  /// direction.
  void drag(Frame& frame, const Vec2& film) override {
    if (dragged_ >= lamps_.size()) return;
    const auto ray = frame.picture ? ray_through(*frame.picture, film) : std::nullopt;
    const SceneParameter* const parameter = frame.info->find(lamps_[dragged_].path);
    if (!ray || !parameter) return;
    const Vec3& forward = frame.camera.controls().forward();
    const float cosine = glm::dot(ray->d, forward);
    if (!(cosine > 1e-3f)) return;
    const Vec3 place = ray->at(glm::dot(grabbed_ - ray->o, forward) / cosine);
    auto value = widgets_.value(*parameter);
    if (!value || !is_finite(place)) return;
    if (auto* const transform = std::get_if<Transform>(&*value)) {
      Mat4 m = transform->matrix();
      m[3] = glm::vec4(place, 1.f);
      value = Placed{Transform(m)};
    } else {
      value = place;
    }
    widgets_.set(frame.session, parameter->path, std::move(*value), true);
  }

 private:
  struct Lamp {
    std::string object;  ///< path of the emitter
    std::string path;    ///< path of the parameter with its position; "" if it has none
    Vec3 place{0.f};
    std::optional<Vec2> seen;  ///< position on the film; nullopt if it isn't visible
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
      // The shape has the position of an area emitter.
      const bool is_surface = parameter.plugin.ends_with("area");
      const std::string placed = is_surface ? object_of(object) : object;
      for (const char* const name : {".position", ".center", ".to_world"}) {
        const SceneParameter* const by = placed.empty() ? nullptr : info.find(placed + name);
        if (!by ||
            (std::string(name) == ".to_world" && parameter.plugin == "emitter/directional")) {
          continue;
        }
        const auto value = widgets_.value(*by);
        if (value && std::holds_alternative<Vec3>(*value)) {
          lamp.place = std::get<Vec3>(*value);
        } else if (value && std::holds_alternative<Transform>(*value)) {
          lamp.place = Vec3(std::get<Transform>(*value).matrix()[3]);
        } else {
          continue;
        }
        lamp.path = by->path;
        break;
      }
      lamps_.push_back(std::move(lamp));
    }
  }

  ParameterWidgets widgets_;
  std::shared_ptr<const SceneInfo> info_;
  uint64_t generation_ = 0;  ///< image from which lamps_ was last updated
  std::vector<Lamp> lamps_;
  bool has_handles_ = true;
  bool is_drawn_ = false;  ///< the side bar has drawn the panel since the last frame
  bool is_open_ = false;
  size_t dragged_ = 0;
  Vec3 grabbed_{0.f};  ///< its position at the start of the drag
};

}  // namespace

std::unique_ptr<Panel> make_lamp_panel() {
  return std::make_unique<LampPanel>();
}

}  // namespace kinome::viewer
