#include <imgui.h>
#include <imgui_stdlib.h>

#include <filesystem>

#include "panels/panel.h"

namespace kinome::viewer {
namespace {

/// Saves the scene as XML, and the image as EXR or PNG.
class SavePanel final : public Panel {
 public:
  const char* title() const override { return "Save"; }

  void draw(Frame& frame) override {
    if (!frame.info) return;
    set_names(*frame.info);
    ImGui::InputText("##scene", &scene_);
    ImGui::SameLine();
    if (ImGui::Button("Save scene")) frame.session.save(scene_);
    ImGui::InputText("##picture", &picture_);
    ImGui::SameLine();
    if (ImGui::Button("Save picture") && frame.picture) {
      try {
        write_picture(picture_, *frame.picture);
        frame.session.say(
            false,
            "wrote " + picture_ + (frame.picture->is_preview ? ", which is only a preview" : ""));
      } catch (const std::exception& fault) {
        frame.session.say(true, fault.what());
      }
    }
  }

  void draw_over_picture(Frame& frame) override {
    if (!frame.wants_save || !frame.info) return;
    set_names(*frame.info);
    frame.session.save(scene_);
  }

 private:
  /// Sets default file names, unless there are names already.
  void set_names(const SceneInfo& info) {
    if (!scene_.empty()) return;
    const std::filesystem::path file(info.file);
    scene_ = (file.parent_path() / (file.stem().string() + "-edited.xml")).string();
    picture_ = file.stem().string() + ".exr";
  }

  std::string scene_, picture_;
};

}  // namespace

std::unique_ptr<Panel> make_save_panel() {
  return std::make_unique<SavePanel>();
}

}  // namespace kinome::viewer
