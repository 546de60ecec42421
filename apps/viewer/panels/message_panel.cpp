#include "panels/message_panel.h"

#include <imgui.h>

namespace kinome::viewer {
namespace {

constexpr size_t kMaxShown = 30;
const ImVec4 kErrorColor(1, 0.45f, 0.4f, 1);

}  // namespace

void MessagePanel::read(const Frame& frame) {
  for (Message& message : frame.session.messages(known_.empty() ? 0 : known_.back().number)) {
    known_.push_back(std::move(message));
  }
  while (known_.size() > kMaxShown) known_.pop_front();
}

void MessagePanel::draw(Frame& frame) {
  read(frame);
  if (known_.empty()) return ImGui::TextDisabled("none");
  ImGui::PushTextWrapPos(0);
  for (auto at = known_.rbegin(); at != known_.rend(); ++at) {
    const Message& message = *at;
    if (message.is_error) ImGui::PushStyleColor(ImGuiCol_Text, kErrorColor);
    ImGui::TextUnformatted(message.text.c_str());
    if (message.is_error) ImGui::PopStyleColor();
  }
  ImGui::PopTextWrapPos();
}

void MessagePanel::draw_over_picture(Frame& frame) {
  read(frame);
  if (known_.empty() || known_.back().number <= seen_ || !known_.back().is_error) return;
  const PictureArea& area = frame.view.area();
  ImGui::SetCursorScreenPos({area.low.x + 8, area.low.y + 8});
  ImGui::PushTextWrapPos(area.high.x - 8);
  ImGui::PushStyleColor(ImGuiCol_Text, kErrorColor);
  ImGui::TextUnformatted(known_.back().text.c_str());
  ImGui::PopStyleColor();
  ImGui::PopTextWrapPos();
  ImGui::SetCursorScreenPos({area.low.x + 8, ImGui::GetCursorScreenPos().y});
  if (ImGui::SmallButton("OK")) seen_ = known_.back().number;
}

}  // namespace kinome::viewer
