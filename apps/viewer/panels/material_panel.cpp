#include <imgui.h>
#include <imgui_stdlib.h>

#include "handles/selection_outline.h"
#include "handles/transform_handles.h"
#include "panels/panel.h"
#include "panels/parameters/parameter_widgets.h"

namespace kinome::viewer {
namespace {

constexpr int kMaxMaterials = 200;

/// All parameters of the selected surface: of its material, shape and emitter. Draws the outline of
/// its shape over the image, and handles that move and turn it.
class MaterialPanel final : public Panel {
 public:
  const char* title() const override { return "Selected surface"; }
  bool is_open_at_first() const override { return true; }

  void draw(Frame& frame) override {
    widgets_.begin(frame.info);
    if (!frame.info) return;
    ImGui::BeginDisabled(!frame.info->can_undo);
    if (ImGui::Button("Undo")) frame.session.undo();
    ImGui::EndDisabled();
    if (!frame.selection) return ImGui::TextDisabled("Click on a surface.");
    const Pick& pick = *frame.selection;
    ImGui::SameLine();
    ImGui::Checkbox("handles", &has_handles_);
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("Arrows and rings in the picture that move and turn the shape (M)");
    }
    ImGui::SameLine();
    ImGui::TextDisabled("at %.3g, %.3g, %.3g", pick.point.x, pick.point.y, pick.point.z);
    if (!widgets_.draw_all(frame.session, *frame.info, with_parts(*frame.info, pick.materials))) {
      ImGui::TextDisabled("The scene has no material for this shape.");
    }
    if (!pick.emitter.empty()) widgets_.draw_all(frame.session, *frame.info, {pick.emitter});
    if (!pick.shape.empty() && ImGui::TreeNode("Shape")) {
      widgets_.draw_all(frame.session, *frame.info, {pick.shape});
      ImGui::TreePop();
    }
  }

  void draw_over_picture(Frame& frame) override {
    widgets_.begin(frame.info);
    outline_.draw(frame);
    if (ImGui::IsKeyPressed('M', false) && !ImGui::GetIO().WantTextInput) {
      has_handles_ = !has_handles_;
    }
    placement_.reset();
    if (has_handles_ && frame.selection && frame.info && frame.tabs.is_live()) {
      placement_ = placement_of(*frame.info, widgets_, frame.selection->shape);
    }
    if (!placement_) return handles_.hide();
    if (const auto* const transform = std::get_if<Transform>(&placement_->value)) {
      if (placed_ != frame.selection) {
        placed_ = frame.selection;
        centre_ = transform->inverse().point(placed_->bounds.centre());
      }
      placement_->position = transform->point(centre_);
    }
    handles_.draw(frame, placement_->position, placement_->can_turn);
  }

  bool press(Frame& frame, const PictureClick& click) override {
    return placement_ && click.button == 0 && handles_.press(frame, click.film, *placement_);
  }
  void drag(Frame& frame, const Vec2& film) override { handles_.drag(frame, film, widgets_); }
  void release(Frame& /*frame*/) override { handles_.release(); }

 private:
  ParameterWidgets widgets_;
  SelectionOutline outline_;
  TransformHandles handles_;
  bool has_handles_ = false;
  std::optional<Placement> placement_;  ///< of the selected shape; nullopt without handles
  std::shared_ptr<const Pick> placed_;  ///< selection of centre_
  Vec3 centre_{0.f};  ///< middle of the shape, before its to_world
};

/// All parameters of the scene, with a search by path.
class ParameterPanel final : public Panel {
 public:
  const char* title() const override { return "All parameters"; }

  void draw(Frame& frame) override {
    widgets_.begin(frame.info);
    if (!frame.info) return;
    ImGui::InputTextWithHint("##wanted", "part of a path", &wanted_);
    int shown = 0;
    for (const SceneParameter& parameter : frame.info->parameters) {
      if (parameter.path.find(wanted_) == std::string::npos) continue;
      if (++shown > kMaxMaterials) {
        ImGui::TextDisabled("... and more");
        break;
      }
      ImGui::TextDisabled("%s", parameter.path.c_str());
      widgets_.draw(frame.session, parameter);
    }
  }

 private:
  ParameterWidgets widgets_;
  std::string wanted_;
};

}  // namespace

std::unique_ptr<Panel> make_material_panel() {
  return std::make_unique<MaterialPanel>();
}
std::unique_ptr<Panel> make_parameter_panel() {
  return std::make_unique<ParameterPanel>();
}

}  // namespace kinome::viewer
