#include <imgui.h>

#include <deque>

#include "panels/panel.h"
#include "panels/widgets.h"

namespace kinome::viewer {
namespace {

constexpr size_t kMaxMessages = 30;

/// Errors, warnings and notes, the latest first.
class MessagePanel final : public Panel {
 public:
  const char* title() const override { return "Messages"; }
  bool is_open_at_first() const override { return true; }

  void draw(Frame& frame) override {
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

  /// Draws the latest message if it is an error that the user hasn't dismissed.
  void draw_over_picture(Frame& frame) override {
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

 private:
  void read(const Frame& frame) {
    for (Message& message : frame.session.messages(known_.empty() ? 0 : known_.back().number)) {
      known_.push_back(std::move(message));
    }
    while (known_.size() > kMaxMessages) known_.pop_front();
  }

  std::deque<Message> known_;
  uint64_t seen_ = 0;  ///< number of the last message that was dismissed
};

}  // namespace

std::unique_ptr<Panel> make_message_panel() {
  return std::make_unique<MessagePanel>();
}

}  // namespace kinome::viewer
