#include <imgui.h>
#include <imgui_stdlib.h>

#include <filesystem>

#include "files/file_picker.h"
#include "panels/panel.h"

namespace kinome::viewer {
namespace {

const std::vector<std::string> kSceneExtensions = {".xml"};
const std::vector<std::string> kPictureExtensions = {".exr", ".png"};
const std::vector<std::string> kReadExtensions = {".exr", ".pfm"};

/// Saves the scene as XML, and the image as EXR or PNG. Opens scenes, and images in tabs.
class SavePanel final : public Panel {
 public:
  const char* title() const override { return "Files"; }

  void draw(Frame& frame) override {
    if (!frame.info) return;
    set_names(*frame.info);
    draw_name("scene", scene_, [&] { save_scene(frame); });
    if (draw_choice("scene")) {
      scene_picker_.open("Save the scene", FilePicker::Purpose::kSave, kSceneExtensions, scene_);
    }
    draw_name("picture", picture_, [&] { save_picture(frame); });
    if (draw_choice("picture")) {
      picture_picker_.open("Save the picture", FilePicker::Purpose::kSave, kPictureExtensions,
                           picture_);
    }
    if (ImGui::Button("Open scene")) open_scene(frame);
    ImGui::SameLine();
    if (ImGui::Button("Open picture")) {
      tab_picker_.open("Open a picture", FilePicker::Purpose::kOpen, kReadExtensions, picture_);
    }
    ImGui::SameLine();
    if (ImGui::Button("Keep in a tab")) {
      // Without the changes of light groups, which apply to each displayed image.
      frame.tabs.keep_displayed(frame.session.picture());
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Ctrl+K; the keys 1 to 9 select a tab");
  }

  void draw_over_picture(Frame& frame) override {
    if (frame.wants_open) open_scene(frame);
    if (const auto file = open_picker_.draw()) frame.session.open(*file);
    if (auto file = scene_picker_.draw()) {
      scene_ = std::move(*file);
      save_scene(frame);
    }
    if (auto file = picture_picker_.draw()) {
      picture_ = std::move(*file);
      save_picture(frame);
    }
    if (const auto file = tab_picker_.draw()) {
      try {
        frame.tabs.open(*file);
      } catch (const std::exception& fault) {
        frame.session.say(true, fault.what());
      }
    }
    if (!frame.wants_save || !frame.info) return;
    set_names(*frame.info);
    save_scene(frame);
  }

 private:
  void open_scene(const Frame& frame) {
    open_picker_.open("Open a scene", FilePicker::Purpose::kOpen, kSceneExtensions,
                      frame.info ? frame.info->file : "");
  }

  void save_scene(Frame& frame) const { frame.session.save(scene_); }

  void save_picture(Frame& frame) const {
    if (!frame.picture) return;
    try {
      write_picture(picture_, *frame.picture);
      frame.session.say(
          false,
          "wrote " + picture_ + (frame.picture->is_preview ? ", which is only a preview" : ""));
    } catch (const std::exception& fault) {
      frame.session.say(true, fault.what());
    }
  }

  /// Draws a file name and the button that saves.
  template <class Save>
  static void draw_name(const char* what, std::string& file, const Save& save) {
    ImGui::PushID(what);
    ImGui::InputText("##file", &file);
    ImGui::SameLine();
    if (ImGui::Button((std::string("Save ") + what).c_str())) save();
    ImGui::PopID();
  }

  /// Draws the button that opens a file dialog.
  static bool draw_choice(const char* what) {
    ImGui::SameLine();
    ImGui::PushID(what);
    const bool is_pressed = ImGui::Button("...");
    ImGui::PopID();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Choose a file");
    return is_pressed;
  }

  /// Sets default file names for each new scene.
  void set_names(const SceneInfo& info) {
    if (file_ == info.file) return;
    const std::filesystem::path file(info.file);
    file_ = info.file;
    scene_ = (file.parent_path() / (file.stem().string() + "-edited.xml")).string();
    picture_ = file.stem().string() + ".exr";
  }

  FilePicker open_picker_, scene_picker_, picture_picker_, tab_picker_;
  std::string file_;  ///< scene of the default names
  std::string scene_, picture_;
};

}  // namespace

std::unique_ptr<Panel> make_save_panel() {
  return std::make_unique<SavePanel>();
}

}  // namespace kinome::viewer
