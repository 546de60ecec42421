#include <imgui.h>
#include <imgui_stdlib.h>

#include "panels/panel.h"
#include "panels/parameter_widgets.h"

namespace kinome::viewer {
namespace {

constexpr int kMaxMaterials = 200;

/// All parameters of the selected surface: of its material, shape and emitter.
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
    ImGui::TextDisabled("   selected: %.3g, %.3g, %.3g", pick.point.x, pick.point.y, pick.point.z);
    if (!widgets_.draw_all(frame.session, *frame.info, with_parts(*frame.info, pick.materials))) {
      ImGui::TextDisabled("The scene has no material for this shape.");
    }
    if (!pick.emitter.empty()) widgets_.draw_all(frame.session, *frame.info, {pick.emitter});
    if (!pick.shape.empty() && ImGui::TreeNode("Shape")) {
      widgets_.draw_all(frame.session, *frame.info, {pick.shape});
      ImGui::TreePop();
    }
  }

 private:
  ParameterWidgets widgets_;
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
