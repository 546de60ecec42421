#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <imgui.h>

namespace kinome::viewer {

/// Height of a line of text at a display scale of 1 [pixels].
inline constexpr float kFontSize = 15;
/// Returns the display scale: pixels of the window per unit of widths.
inline float display_scale() {
  return ImGui::GetFontSize() / kFontSize;
}

inline const ImVec4 kErrorColor(1, 0.45f, 0.4f, 1);

/// Draws an error message, with line breaks where necessary.
inline void draw_error(const std::string& text) {
  ImGui::PushTextWrapPos(0);
  ImGui::TextColored(kErrorColor, "%s", text.c_str());
  ImGui::PopTextWrapPos();
}

/// Returns a number with its noun: "1 sample", "2 samples".
inline std::string counted(double count, const std::string& noun) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f ", count);
  return text + noun + (count == 1 ? "" : "s");
}

/// Draws a menu in which `shown` is selected. Returns the index of the name that the user selects.
inline std::optional<size_t> choose(const char* label, const std::string& shown,
                                    const std::vector<std::string>& names) {
  std::optional<size_t> chosen;
  if (!ImGui::BeginCombo(label, shown.c_str())) return chosen;
  for (size_t i = 0; i < names.size(); ++i) {
    if (ImGui::Selectable(names[i].c_str(), names[i] == shown)) chosen = i;
  }
  ImGui::EndCombo();
  return chosen;
}

}  // namespace kinome::viewer
