#include "files/file_picker.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <utility>

#include "panels/widgets.h"

namespace kinome::viewer {
namespace {

namespace fs = std::filesystem;

bool is_pressed(ImGuiKey key) {
  return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key));
}

/// Returns "*.exr, *.png".
std::string pattern_of(const std::vector<std::string>& extensions) {
  std::string text;
  for (const std::string& extension : extensions) text += (text.empty() ? "*" : ", *") + extension;
  return text.empty() ? "all files" : text;
}

}  // namespace

void FilePicker::open(const char* title, Purpose purpose, std::vector<std::string> extensions,
                      const fs::path& start) {
  title_ = title;
  purpose_ = purpose;
  extensions_ = std::move(extensions);
  std::error_code fault;
  const fs::path whole =
      fs::absolute(start.empty() ? fs::path(".") : start, fault).lexically_normal();
  const bool is_folder = fs::is_directory(whole, fault);
  go_to(is_folder ? path_in(whole, "") : whole.parent_path());
  set_text(!is_folder && purpose == Purpose::kSave ? whole.filename().string() : "");
  if (!is_folder) {
    const auto found = std::ranges::find(shown_, whole.filename().string(), &FileEntry::name);
    if (found != shown_.end()) selected_ = static_cast<int>(found - shown_.begin());
  }
  is_opening_ = true;
}

void FilePicker::go_to(const fs::path& folder) {
  folder_ = folder;
  list_ = list_files(folder, extensions_);
  shown_ = list_.entries;
  if (purpose_ == Purpose::kOpen) set_text("");
  selected_ = -1;
  is_typed_ = asks_to_replace_ = false;
  wants_focus_ = scrolls_ = true;
}

void FilePicker::set_text(std::string text) {
  text_ = std::move(text);
  ++text_version_;
}

/// Draws a button for each folder of the path.
void FilePicker::draw_path() {
  fs::path part, chosen;
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  for (const fs::path& name : folder_) {
    part /= name;
    const float width = ImGui::CalcTextSize(name.c_str()).x + ImGui::GetStyle().FramePadding.x * 2;
    if (part != name && ImGui::GetItemRectMax().x + 4 + width < right) ImGui::SameLine(0, 4);
    ImGui::PushID(part.c_str());
    if (ImGui::Button(name.c_str())) chosen = part;
    ImGui::PopID();
  }
  if (!chosen.empty()) go_to(chosen);
}

void FilePicker::move_selection() {
  const int count = static_cast<int>(shown_.size());
  int step = 0;
  if (is_pressed(ImGuiKey_DownArrow)) step = 1;
  if (is_pressed(ImGuiKey_UpArrow)) step = -1;
  if (is_pressed(ImGuiKey_PageDown)) step = 10;
  if (is_pressed(ImGuiKey_PageUp)) step = -10;
  if (step == 0 || count == 0) return;
  selected_ =
      selected_ < 0 ? (step > 0 ? 0 : count - 1) : std::clamp(selected_ + step, 0, count - 1);
  is_typed_ = asks_to_replace_ = false;
  scrolls_ = true;
  if (purpose_ == Purpose::kOpen || shown_[selected_].is_folder) return;
  set_text(shown_[selected_].name);
  wants_focus_ = true;
}

bool FilePicker::draw_list(float height) {
  bool is_double = false;
  ImGui::BeginChild("files", {0, -height}, true);
  if (!list_.fault.empty()) ImGui::TextWrapped("%s", list_.fault.c_str());
  for (int i = 0; i < static_cast<int>(shown_.size()); ++i) {
    const FileEntry& entry = shown_[i];
    const std::string label = entry.is_folder ? entry.name + "/" : entry.name;
    if (entry.is_folder) ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.6f, 0.8f, 1, 1));
    if (ImGui::Selectable(label.c_str(), i == selected_, ImGuiSelectableFlags_AllowDoubleClick)) {
      selected_ = i;
      is_typed_ = asks_to_replace_ = false;
      if (purpose_ == Purpose::kSave && !entry.is_folder) set_text(entry.name);
      is_double = ImGui::IsMouseDoubleClicked(0);
    }
    if (entry.is_folder) ImGui::PopStyleColor();
    if (scrolls_ && i == selected_) ImGui::SetScrollHereY();
  }
  scrolls_ = false;
  if (shown_.empty() && list_.fault.empty()) {
    ImGui::TextDisabled(list_.entries.empty() ? "The folder has no such files."
                                              : "Nothing matches.");
  }
  ImGui::EndChild();
  return is_double;
}

std::optional<std::string> FilePicker::accept() {
  fs::path path;
  std::error_code fault;
  if (selected_ >= 0 && !is_typed_) {
    path = folder_ / shown_[selected_].name;
  } else if (!text_.empty()) {
    path = path_in(folder_, text_);
    // Part of a name selects the first match.
    const bool is_part = purpose_ == Purpose::kOpen && !fs::exists(path, fault);
    if (is_part && !shown_.empty()) path = folder_ / shown_[std::max(selected_, 0)].name;
  } else {
    return std::nullopt;
  }
  if (fs::is_directory(path, fault)) {
    if (is_typed_) set_text("");
    go_to(path);
    return std::nullopt;
  }
  if (purpose_ == Purpose::kOpen) {
    return fs::exists(path, fault) ? std::optional(path.string()) : std::nullopt;
  }
  path = with_extension(path, extensions_);
  if (fs::exists(path, fault) && !std::exchange(asks_to_replace_, true)) return std::nullopt;
  return path.string();
}

std::optional<std::string> FilePicker::draw() {
  if (is_opening_) ImGui::OpenPopup(title_);
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float unit = display_scale();
  ImGui::SetNextWindowPos({0.5f * size.x, 0.5f * size.y}, ImGuiCond_Appearing, {0.5f, 0.5f});
  ImGui::SetNextWindowSize(
      {std::min(640 * unit, 0.9f * size.x), std::min(460 * unit, 0.9f * size.y)},
      ImGuiCond_Appearing);
  is_opening_ = false;
  bool is_open = true;
  if (!ImGui::BeginPopupModal(title_, &is_open, ImGuiWindowFlags_NoSavedSettings)) {
    return std::nullopt;
  }
  std::optional<std::string> chosen;
  draw_path();
  bool is_accepted = draw_list(2 * ImGui::GetFrameHeightWithSpacing());
  if (std::exchange(wants_focus_, false)) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(-180 * unit);
  const std::string before = text_;
  ImGui::PushID(text_version_);
  is_accepted |= ImGui::InputTextWithHint("##name", "name, or part of it", &text_,
                                          ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::PopID();
  ImGui::SameLine();
  ImGui::TextDisabled("%s", pattern_of(extensions_).c_str());
  if (text_ != before) {
    is_typed_ = true;
    asks_to_replace_ = false;
    shown_ = purpose_ == Purpose::kOpen ? matching(list_.entries, text_) : list_.entries;
    selected_ = purpose_ == Purpose::kOpen && !shown_.empty() && !text_.empty() ? 0 : -1;
  }
  move_selection();
  const char* const action = asks_to_replace_               ? "Replace"
                             : purpose_ == Purpose::kOpen ? "Open"
                                                          : "Save";
  is_accepted |= ImGui::Button(action, {90 * unit, 0});
  ImGui::SameLine();
  if (ImGui::Button("Cancel", {90 * unit, 0}) || is_pressed(ImGuiKey_Escape)) is_open = false;
  if (asks_to_replace_) {
    ImGui::SameLine();
    ImGui::TextColored(ImVec4(1, 0.8f, 0.4f, 1), "This file exists already.");
  }
  if (is_accepted) {
    chosen = accept();
    wants_focus_ = !chosen;
  }
  if (chosen || !is_open) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
  return chosen;
}

}  // namespace kinome::viewer
