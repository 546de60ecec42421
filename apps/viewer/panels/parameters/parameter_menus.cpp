// Menus of parameters and materials: textures, defaults, normal maps and bump maps.

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

#include "panels/parameters/parameter_widgets.h"
#include "session/put_objects.h"

namespace kinome::viewer {
namespace {

const ImVec4 kNameColor(0.6f, 0.8f, 1, 1);

}  // namespace

std::optional<EditedValue> ParameterWidgets::first_value(const SceneParameter& parameter) {
  static const std::map<ParameterType, EditedValue> values = {
      {ParameterType::kBoolean, true},
      {ParameterType::kInteger, int64_t{1}},
      {ParameterType::kFloat, 1.0},
      {ParameterType::kFloatOrName, 1.0},
      {ParameterType::kVector, Vec3(0.f)},
      {ParameterType::kTransform, Transform()},
      {ParameterType::kEmission, UniformColor{Rgb(0.5f)}},
      {ParameterType::kEmissionTexture, UniformColor{Rgb(0.5f)}},
      {ParameterType::kReflectanceTexture, UniformColor{Rgb(0.5f)}},
      {ParameterType::kColorTexture, UniformColor{Rgb(0.5f)}},
      {ParameterType::kVolume, UniformColor{Rgb(0.5f), false, true}},
      {ParameterType::kUnitlessTexture, UniformColor{Rgb(0.5f), false, true}}};
  const auto found = parameter.kind ? values.find(*parameter.kind) : values.end();
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

std::vector<std::string> image_files(const SceneInfo& info) {
  std::vector<std::string> found = files_beside("x.png", info.file);
  for (const SceneParameter& parameter : info.parameters) {
    const auto* const file =
        parameter.value ? std::get_if<std::string>(&*parameter.value) : nullptr;
    if (parameter.kind != ParameterType::kFile || !file || !is_image(*file)) continue;
    const auto beside = files_beside(*file, info.file);
    found.insert(found.end(), beside.begin(), beside.end());
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::optional<std::string> ParameterWidgets::choose_image(const char* title) {
  if (!ImGui::BeginMenu(title)) return std::nullopt;
  std::optional<std::string> chosen;
  if (images_.empty() && info_) images_ = image_files(*info_);
  for (const std::string& file : images_) {
    if (ImGui::MenuItem(file.c_str())) chosen = file;
  }
  if (ImGui::InputTextWithHint("##file", "another file, Enter", &file_,
                               ImGuiInputTextFlags_EnterReturnsTrue) &&
      !file_.empty()) {
    chosen = file_;
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndMenu();
  if (chosen) images_.clear();
  return chosen;
}

/// Draws the menu of a parameter: textures, default, and the value of the scene file.
void ParameterWidgets::draw_menu(RenderSession& session, const SceneParameter& parameter) {
  ImGui::AlignTextToFramePadding();  // in a row with larger widgets
  if (ImGui::SmallButton("=")) {
    images_.clear();
    ImGui::OpenPopup("menu");
  }
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("texture, default, ...");
  ImGui::SameLine();
  if (!ImGui::BeginPopup("menu")) return;
  const bool takes = parameter.kind && takes_texture(*parameter.kind) &&
                     parameter.kind != ParameterType::kVolume;
  if (takes) {
    const auto file = choose_image("texture from a file");
    const bool is_raw = parameter.kind == ParameterType::kUnitlessTexture;
    if (file) set(session, parameter.path, bitmap(*file, is_raw), false);
    if (ImGui::MenuItem("checkerboard")) set(session, parameter.path, checkerboard(), false);
  }
  const auto first = first_value(parameter);
  if (!parameter.texture.empty() && first && ImGui::MenuItem("value in place of the texture")) {
    set(session, parameter.path, *first, false);
  }
  const bool has_any = parameter.is_set || !parameter.texture.empty();
  const char* const title = parameter.default_value ? "default" : "none";
  if (ImGui::MenuItem(title, nullptr, false, has_any)) {
    set(session, parameter.path, Unset{}, false);
  }
  if (ImGui::MenuItem("as in the scene's file", nullptr, false, parameter.is_edited)) {
    set(session, parameter.path, AsWritten{}, false);
  }
  ImGui::EndPopup();
}

/// Draws the name of an object. Materials get a menu of normal maps and bump maps.
void ParameterWidgets::draw_name(RenderSession& session, const SceneInfo& info,
                                 const std::string& object, const std::string& plugin) {
  if (plugin.starts_with("bsdf/")) {
    if (ImGui::SmallButton("+")) {
      images_.clear();
      ImGui::OpenPopup("around");
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("normal map, bump map");
    ImGui::SameLine();
    if (ImGui::BeginPopup("around")) {
      for (const auto& [title, map] : {std::pair("normal map from a file", "normalmap"),
                                       std::pair("bump map from a file", "bumpmap")}) {
        const auto file = choose_image(title);
        if (file) session.set({{object, map_around(map, *file)}});
      }
      const SceneObject* const known = info.find_object(object);
      if (ImGui::MenuItem("take this map off", nullptr, false, known && known->is_around)) {
        session.set({{object, Unset{}}});
      }
      ImGui::EndPopup();
    }
  }
  ImGui::TextColored(kNameColor, "%s", object.c_str());
  ImGui::SameLine();
  ImGui::TextDisabled("%s", plugin.c_str());
}

void ParameterWidgets::draw_textured(RenderSession& session, const SceneInfo& info,
                                     const SceneParameter& parameter) {
  ImGui::PushID(parameter.path.c_str());
  draw_menu(session, parameter);
  const SceneObject* const texture = info.find_object(parameter.texture);
  ImGui::Text("%s: %s", last_name(parameter.path).c_str(),
              texture ? texture->plugin.c_str() : parameter.texture.c_str());
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", parameter.doc.c_str());
  ImGui::PopID();
}

}  // namespace kinome::viewer
