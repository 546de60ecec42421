#include "panels/save_panel.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <filesystem>

namespace kinome::viewer {

/// Sets default file names, unless there are names already.
void SavePanel::set_names(const SceneInfo& info) {
  if (!scene_.empty()) return;
  const std::filesystem::path file(info.file);
  scene_ = (file.parent_path() / (file.stem().string() + "-edited.xml")).string();
  picture_ = file.stem().string() + ".exr";
}

void SavePanel::draw_over_picture(Frame& frame) {
  if (!frame.wants_save || !frame.info) return;
  set_names(*frame.info);
  frame.session.save(scene_);
}

void SavePanel::draw(Frame& frame) {
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
      frame.session.say(false, "wrote " + picture_ +
                                   (frame.picture->is_preview ? ", which is only a preview" : ""));
    } catch (const std::exception& fault) {
      frame.session.say(true, fault.what());
    }
  }
}

}  // namespace kinome::viewer
