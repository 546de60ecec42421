#include "panels/parameters/parameter_widgets.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cfloat>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <glm/gtc/matrix_transform.hpp>

#include "panels/parameters/parameter_order.h"
#include "panels/widgets.h"
#include "camera/transforms.h"

namespace kinome::viewer {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxFiles = 200;

/// Returns the drag speed, which increases with the value.
float speed_of(float value) {
  return std::max(0.002f, 0.005f * std::abs(value));
}

bool edit_number(const SceneParameter& parameter, const char* name, double& value) {
  auto number = static_cast<float>(value);
  bool is_new;
  if (std::isfinite(parameter.low) && std::isfinite(parameter.high)) {
    is_new = ImGui::SliderFloat(name, &number, static_cast<float>(parameter.low),
                                static_cast<float>(parameter.high), "%.3f");
  } else {
    is_new = ImGui::DragFloat(name, &number, speed_of(number), 0, 0, "%.4g");
  }
  if (is_new) value = number;
  return is_new;
}

bool edit_color(const SceneParameter& parameter, const char* name, UniformColor& color) {
  if (color.is_float) {
    double grey = color.value.x;
    if (parameter.kind != ParameterType::kUnitlessTexture) {
      if (ImGui::SmallButton("colour")) {
        color.is_float = false;
        return true;
      }
      ImGui::SameLine();
    }
    if (!edit_number(parameter, name, grey)) return false;
    color.value = Rgb(static_cast<float>(grey));
    return true;
  }
  const bool is_limited = std::isfinite(parameter.high);
  const ImGuiColorEditFlags flags =
      ImGuiColorEditFlags_Float | (is_limited ? 0 : ImGuiColorEditFlags_HDR);
  if (!ImGui::ColorEdit3(name, &color.value.x, flags)) return false;
  color.spectral = false;
  return true;
}

/// Edits emission as a power and a colour whose largest component is 1.
bool edit_light(const char* name, UniformColor& color) {
  Rgb& c = color.value;
  float power = max_component(c);
  Rgb hue = power > 0 ? c / power : Rgb(1.f);
  bool is_new = ImGui::DragFloat(name, &power, speed_of(power), 0, FLT_MAX, "%.4g");
  if (ImGui::ColorEdit3("colour", &hue.x, ImGuiColorEditFlags_Float)) {
    is_new = true;
    color.spectral = color.is_float = false;
  }
  if (is_new) c = std::max(0.f, power) * hue;
  return is_new;
}

}  // namespace

std::string object_of(const std::string& path) {
  const std::string whole = path.ends_with(".value") ? path.substr(0, path.size() - 6) : path;
  const size_t dot = whole.rfind('.');
  return dot == std::string::npos ? "" : whole.substr(0, dot);
}

std::vector<std::string> with_parts(const SceneInfo& info,
                                    const std::vector<std::string>& objects) {
  std::vector<std::string> paths;
  const auto add = [&](const std::string& path) {
    const bool is_known = std::find(paths.begin(), paths.end(), path) != paths.end();
    if (!is_known && info.find_object(path)) paths.push_back(path);
  };
  for (const std::string& object : objects) {
    add(object);
    for (const SceneObject& other : info.objects) {
      if (other.path.starts_with(object + ".")) add(other.path);
    }
  }
  // Textures with ids of their own have paths that don't start with the object's.
  for (size_t i = 0; i < paths.size(); ++i) {
    for (const SceneParameter& parameter : info.textured) {
      if (object_of(parameter.path) == paths[i]) add(parameter.texture);
    }
  }
  return paths;
}

bool is_image(const std::string& file) {
  const std::string ending = fs::path(file).extension().string();
  return ending == ".exr" || ending == ".hdr" || ending == ".pfm" || ending == ".png" ||
         ending == ".jpg" || ending == ".ppm";
}

std::string ParameterWidgets::last_name(const std::string& path) {
  const std::string whole = path.ends_with(".value") ? path.substr(0, path.size() - 6) : path;
  return whole.substr(whole.rfind('.') + 1);
}

std::vector<std::string> files_beside(const std::string& file, const std::string& scene) {
  std::error_code fault;
  const fs::path own(file);
  fs::path folder =
      own.is_absolute() ? own.parent_path() : fs::path(scene).parent_path() / own.parent_path();
  if (folder.empty()) folder = ".";
  std::vector<std::string> found;
  for (fs::directory_iterator at(folder, fault), end; !fault && at != end; at.increment(fault)) {
    const fs::directory_entry& entry = *at;
    const std::string ending = entry.path().extension().string();
    if (ending != own.extension() &&
        !(is_image(entry.path().string()) && own.extension() != ".ply")) {
      continue;
    }
    // The path is relative to the same folder as the parameter's own.
    found.push_back((own.parent_path() / entry.path().filename()).string());
    if (found.size() == kMaxFiles) break;
  }
  std::sort(found.begin(), found.end());
  return found;
}

void ParameterWidgets::begin(const std::shared_ptr<const SceneInfo>& info) {
  if (info_ == info || ImGui::IsAnyItemActive()) return;
  if (info && info->served < entered_number_) return;  // older than the last entered value
  info_ = info;
  entered_.clear();
}

std::optional<EditedValue> ParameterWidgets::value(const SceneParameter& parameter) const {
  const auto found = entered_.find(parameter.path);
  if (found != entered_.end()) {
    if (const auto* const placed = std::get_if<Placed>(&found->second)) return placed->transform;
  }
  const bool is_value = found != entered_.end() &&
                        !std::holds_alternative<ObjectDescription>(found->second) &&
                        !std::holds_alternative<Unset>(found->second) &&
                        !std::holds_alternative<AsWritten>(found->second);
  return is_value ? std::optional(found->second) : parameter.value;
}

void ParameterWidgets::set(RenderSession& session, const std::string& path, EditedValue value,
                           bool is_moving) {
  entered_[path] = value;
  entered_number_ = session.set({{path, std::move(value)}}, is_moving);
}

bool ParameterWidgets::edit_text(const SceneParameter& parameter, const char* name,
                                 std::string& text) {
  const std::vector<std::string>& choices = parameter.choices;
  if (!choices.empty()) {
    const auto chosen = choose(name, text, choices);
    if (chosen) text = choices[*chosen];
    return chosen.has_value();
  }
  // Applies text only after Enter.
  const auto [typed, is_first] = typed_.emplace(parameter.path, text);
  const bool is_done = ImGui::InputText(name, &typed->second, ImGuiInputTextFlags_EnterReturnsTrue);
  const std::string entered = typed->second;
  if (!ImGui::IsItemActive()) typed_.erase(typed);
  if (!is_done || entered == text) return false;
  text = entered;
  return true;
}

bool ParameterWidgets::edit_file(const char* name, std::string& file) {
  bool is_new = false;
  ImGui::SameLine();
  if (!ImGui::BeginCombo((std::string("##files") + name).c_str(), "", ImGuiComboFlags_NoPreview)) {
    return false;
  }
  for (const std::string& other : files_beside(file, info_ ? info_->file : "")) {
    if (!ImGui::Selectable(other.c_str(), other == file)) continue;
    file = other;
    is_new = true;
  }
  ImGui::EndCombo();
  return is_new;
}

bool ParameterWidgets::edit_transform(const SceneParameter& parameter, Transform& transform) {
  Turn& turn = turns_[parameter.path];
  // Starts again from a value that was set elsewhere.
  if (!are_alike(turn.now, transform.matrix())) turn = {transform.matrix(), transform.matrix()};
  Mat4 m = turn.now;
  bool is_new = false;
  Vec3 place(m[3]);
  if (ImGui::DragFloat3("place", &place.x, speed_of(glm::length(place)), 0, 0, "%.4g")) {
    is_new = true;
  }
  is_new |= ImGui::DragFloat3("turn", &turn.degrees.x, 0.5f, -360, 360, "%.1f");
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("degrees around x, y and z");
  // The transforms of emitters and sensors have no size.
  const bool has_size =
      !parameter.plugin.starts_with("emitter/") && !parameter.plugin.starts_with("sensor/");
  if (has_size) is_new |= ImGui::DragFloat("size", &turn.size, 0.005f, 0.01f, 100, "%.3f");
  if (!is_new || !(turn.size > 0)) return false;
  m = turn.base;
  m[3] = glm::vec4(0, 0, 0, 1);
  m = m * glm::scale(Mat4(1.f), Vec3(turn.size));
  for (int i = 0; i < 3; ++i) {
    Vec3 axis(0.f);
    axis[i] = 1;
    if (turn.degrees[i] != 0) m = glm::rotate(Mat4(1.f), glm::radians(turn.degrees[i]), axis) * m;
  }
  m[3] = glm::vec4(place, 1.f);
  turn.now = m;
  transform = Transform(m);
  return true;
}

bool ParameterWidgets::edit(const SceneParameter& parameter, const char* name, EditedValue& value) {
  if (auto* const flag = std::get_if<bool>(&value)) return ImGui::Checkbox(name, flag);
  if (auto* const integer = std::get_if<int64_t>(&value)) {
    auto number = static_cast<int>(std::clamp<int64_t>(*integer, INT32_MIN, INT32_MAX));
    if (!ImGui::InputInt(name, &number)) return false;
    *integer = number;
    return true;
  }
  if (auto* const number = std::get_if<double>(&value)) {
    return edit_number(parameter, name, *number);
  }
  if (auto* const text = std::get_if<std::string>(&value)) {
    bool is_new = edit_text(parameter, name, *text);
    if (parameter.kind == ParameterType::kFile) is_new |= edit_file(name, *text);
    if (is_new && parameter.kind == ParameterType::kFloatOrName) {
      double number = 0;
      const char* const end = text->data() + text->size();
      const auto [rest, error] = std::from_chars(text->data(), end, number);
      if (error == std::errc{} && rest == end) value = number;
    }
    return is_new;
  }
  if (auto* const v = std::get_if<Vec3>(&value)) {
    return ImGui::DragFloat3(name, &v->x, speed_of(glm::length(*v)), 0, 0, "%.4g");
  }
  if (auto* const color = std::get_if<UniformColor>(&value)) {
    const bool is_light = parameter.kind == ParameterType::kEmission ||
                          parameter.kind == ParameterType::kEmissionTexture;
    return is_light ? edit_light(name, *color) : edit_color(parameter, name, *color);
  }
  if (auto* const transform = std::get_if<Transform>(&value)) {
    return edit_transform(parameter, *transform);
  }
  ImGui::TextDisabled("%s: %s", name, parameter.type.c_str());
  return false;
}

void ParameterWidgets::draw(RenderSession& session, const SceneParameter& parameter) {
  const std::string name = last_name(parameter.path);
  ImGui::PushID(parameter.path.c_str());
  draw_menu(session, parameter);
  if (auto now = value(parameter)) {
    ImGui::BeginGroup();
    const bool is_new = edit(parameter, name.c_str(), *now);
    ImGui::EndGroup();
    if (ImGui::IsItemHovered() && !ImGui::IsAnyItemActive()) {
      ImGui::SetTooltip("%s: %s%s", last_name(parameter.path).c_str(), parameter.doc.c_str(),
                        parameter.is_set ? "" : " (default)");
    }
    if (is_new) {
      if (const auto* const transform = std::get_if<Transform>(&*now)) now = Placed{*transform};
      set(session, parameter.path, std::move(*now), ImGui::IsAnyItemActive());
    }
  } else {
    ImGui::TextDisabled("%s: %s, not set", name.c_str(), parameter.type.c_str());
    auto first = first_value(parameter);
    if (first) {
      ImGui::SameLine();
      if (ImGui::SmallButton("set")) set(session, parameter.path, std::move(*first), false);
    }
  }
  ImGui::PopID();
}

bool ParameterWidgets::draw_all(RenderSession& session, const SceneInfo& info,
                                const std::vector<std::string>& objects) {
  bool has_any = false;
  for (const std::string& object : objects) {
    const SceneObject* const known = info.find_object(object);
    if (!known) continue;
    has_any = true;
    ImGui::PushID(object.c_str());
    draw_name(session, info, object, known->plugin);
    ImGui::Indent(8);
    for (const SceneParameter& parameter : info.textured) {
      if (object_of(parameter.path) == object) draw_textured(session, info, parameter);
    }
    const OrderedParameters parameters = ordered_parameters(info, object);
    for (const SceneParameter* const parameter : parameters.usual) draw(session, *parameter);
    if (!parameters.advanced.empty() && ImGui::TreeNode("advanced")) {
      for (const SceneParameter* const parameter : parameters.advanced) draw(session, *parameter);
      ImGui::TreePop();
    }
    ImGui::Unindent(8);
    ImGui::PopID();
  }
  return has_any;
}

}  // namespace kinome::viewer
