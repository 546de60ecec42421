#include <imgui.h>

#include "panels/panel.h"

namespace kinome::viewer {
namespace {

/// Light groups: the intensity and colour of each. Changes are displayed without a render.
class LightPanel final : public Panel {
 public:
  const char* title() const override { return "Light groups"; }

  void draw(Frame& frame) override {
    if (frame.lights.groups().empty()) {
      ImGui::PushTextWrapPos(0);
      ImGui::TextDisabled("The picture has none: see light_groups of the integrator aov.");
      ImGui::PopTextWrapPos();
      return;
    }
    for (LightSliders::Group& group : frame.lights.groups()) {
      ImGui::PushID(group.name.c_str());
      ImGui::ColorEdit3("##color", &group.color.x,
                        ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_Float);
      ImGui::SameLine();
      ImGui::SliderFloat(group.name.c_str(), &group.intensity, 0, LightSliders::kMaxIntensity,
                         "%.3g", ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
      if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("Factor of the light of this group; Ctrl-click to type");
      }
      ImGui::PopID();
    }
    if (ImGui::Button("Reset")) frame.lights.reset();
  }
};

}  // namespace

std::unique_ptr<Panel> make_light_panel() {
  return std::make_unique<LightPanel>();
}

}  // namespace kinome::viewer
