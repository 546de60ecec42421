#include "panels/material_panel.h"

#include <imgui.h>
#include <imgui_stdlib.h>

namespace kinome::viewer {
namespace {

constexpr int kMostShown = 200;

}  // namespace

void MaterialPanel::draw(Frame& frame) {
  widgets_.begin(frame.info);
  if (!frame.info) return;
  if (frame.info->can_undo) {
    if (ImGui::Button("Undo")) frame.session.undo();
  } else {
    ImGui::TextDisabled("Undo");
  }
  if (!frame.selection) return ImGui::TextDisabled("Click on a surface.");
  const Pick& pick = *frame.selection;
  ImGui::SameLine();
  ImGui::TextDisabled("at %.3g, %.3g, %.3g", pick.point.x, pick.point.y, pick.point.z);
  if (!widgets_.draw_all(frame.session, *frame.info, pick.materials)) {
    ImGui::TextDisabled("The scene says no material for this shape.");
  }
  if (!pick.emitter.empty()) widgets_.draw_all(frame.session, *frame.info, {pick.emitter});
  if (!pick.shape.empty() && ImGui::TreeNode("Shape")) {
    widgets_.draw_all(frame.session, *frame.info, {pick.shape});
    ImGui::TreePop();
  }
}

void ParameterPanel::draw(Frame& frame) {
  widgets_.begin(frame.info);
  if (!frame.info) return;
  ImGui::InputTextWithHint("##wanted", "part of a path", &wanted_);
  int shown = 0;
  for (const SceneParameter& parameter : frame.info->parameters) {
    if (parameter.path.find(wanted_) == std::string::npos) continue;
    if (++shown > kMostShown) {
      ImGui::TextDisabled("... and more");
      break;
    }
    ImGui::TextDisabled("%s", parameter.path.c_str());
    widgets_.draw(frame.session, parameter);
  }
}

}  // namespace kinome::viewer
