#include <imgui.h>

#include "panels/panel.h"
#include "panels/parameters/parameter_widgets.h"

namespace kinome::viewer {
namespace {

/// Media, with the parameters of their phase functions and volumes.
class MediumPanel final : public Panel {
 public:
  const char* title() const override { return "Media"; }

  void draw(Frame& frame) override {
    widgets_.begin(frame.info);
    if (!frame.info) return;
    std::vector<std::string> media;
    for (const SceneObject& object : frame.info->objects) {
      if (object.plugin.starts_with("medium/")) media.push_back(object.path);
    }
    if (media.empty()) return ImGui::TextDisabled("The scene has none.");
    for (const std::string& medium : media) {
      ImGui::SetNextItemOpen(media.size() == 1, ImGuiCond_Once);
      if (!ImGui::TreeNode(medium.c_str())) continue;
      widgets_.draw_all(frame.session, *frame.info, with_parts(*frame.info, {medium}));
      ImGui::TreePop();
    }
  }

 private:
  ParameterWidgets widgets_;
};

}  // namespace

std::unique_ptr<Panel> make_medium_panel() {
  return std::make_unique<MediumPanel>();
}

}  // namespace kinome::viewer
