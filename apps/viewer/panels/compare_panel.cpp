#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <future>
#include <memory>
#include <string>

#include "files/file_picker.h"
#include "panels/panel.h"
#include "panels/picture_overlay.h"
#include "panels/widgets.h"
#include "picture/display.h"

namespace kinome::viewer {
namespace {

/// Minimum time between two comparisons with the same settings.
constexpr std::chrono::milliseconds kMinCompareInterval{1000};
/// Maximum distance of the mouse to the split line for a drag [pixels of the window].
constexpr float kLineTolerance = 8;

/// Comparison of the image with a reference from a file, or with an earlier state of the image.
/// Shows them side by side, or their difference, and reports relMSE and FLIP.
class ComparePanel final : public Panel {
 public:
  explicit ComparePanel(std::shared_ptr<Display> display) : display_(std::move(display)) {}
  const char* title() const override { return "Compare"; }

  void draw(Frame& frame) override {
    draw_reference(frame);
    if (!display_->reference) return ImGui::TextDisabled("no reference yet");
    draw_shown(frame);
    draw_errors();
  }

  void draw_over_picture(Frame& frame) override {
    const auto chosen = picker_.draw();
    const std::string file = chosen ? *chosen : frame.reference;
    if (!file.empty()) {
      std::snprintf(path_, sizeof path_, "%s", file.c_str());
      load(frame, file);
      if (!fault_.empty()) frame.session.say(true, fault_);
    }
    follow(frame);
    if (!display_->reference || !frame.picture) return;
    const PictureArea& area = frame.view.area();
    ImDrawList* const list = ImGui::GetWindowDrawList();
    if (display_->shown == Shown::kSplit) {
      const float x = split_at(frame), top = std::max(area.low.y, area.corner.y);
      const float bottom = std::min(
          area.high.y, area.corner.y + area.scale * static_cast<float>(area.crop.height()));
      list->AddLine({x, top}, {x, bottom}, IM_COL32(255, 200, 60, 255), 2);
      list->AddCircleFilled({x, 0.5f * (top + bottom)}, 6, IM_COL32(255, 200, 60, 255));
      list->AddText({x - 8 - ImGui::CalcTextSize("picture").x, top + 6},
                    IM_COL32(255, 200, 60, 255), "picture");
      list->AddText({x + 8, top + 6}, IM_COL32(255, 200, 60, 255), "reference");
    } else if (display_->shown == Shown::kDifference && display_->difference) {
      constexpr const char* kTexts[] = {
          "picture - reference", "(picture - reference) by the reference", "FLIP", "HDR-FLIP"};
      draw_color_legend(area, display_->difference_tone, kTexts[static_cast<int>(kind_)]);
    }
  }

  /// Starts a drag of the line between the image and the reference.
  bool press(Frame& frame, const PictureClick& click) override {
    if (!display_->reference || display_->shown != Shown::kSplit || click.button != 0) return false;
    return std::abs(frame.view.area().to_window(click.film).x - split_at(frame)) <= kLineTolerance;
  }

  void drag(Frame& frame, const Vec2& film) override {
    const Rect& crop = frame.view.area().crop;
    const float share =
        (film.x - static_cast<float>(crop.x0)) / static_cast<float>(std::max(1, crop.width()));
    display_->split = std::clamp(share, 0.f, 1.f);
    frame.view.refresh();
  }

 private:
  /// Loads a reference from the source, an argument list of Reference.
  template <class... Source>
  void load(Frame& frame, const Source&... source) {
    try {
      set_reference(frame, std::make_shared<const Reference>(source...));
    } catch (const std::exception& fault) {
      fault_ = fault.what();
    }
  }

  void draw_reference(Frame& frame) {
    if (ImGui::InputTextWithHint("reference##file", "file.exr, Enter", path_, sizeof path_,
                                 ImGuiInputTextFlags_EnterReturnsTrue)) {
      load(frame, std::string(path_));
    }
    if (ImGui::Button("Load")) {
      const std::string start = path_[0] == 0 && frame.info ? frame.info->file : path_;
      picker_.open("Open a reference", FilePicker::Purpose::kOpen, {".exr"}, start);
    }
    ImGui::SameLine();
    if (ImGui::Button("Keep this picture") && frame.picture) {
      load(frame, frame.picture->image, "kept picture");
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Use this picture as the reference");
    if (display_->reference) {
      ImGui::SameLine();
      if (ImGui::Button("None")) set_reference(frame, nullptr);
    }
    if (!fault_.empty()) draw_error(fault_);
  }

  void draw_shown(Frame& frame) {
    constexpr const char* kNames[] = {"picture", "reference", "split", "difference"};
    for (int i = 0; i < 4; ++i) {
      if (i > 0) ImGui::SameLine();
      if (!ImGui::RadioButton(kNames[i], static_cast<int>(display_->shown) == i)) continue;
      display_->shown = static_cast<Shown>(i);
      update_tone(frame);
    }
    if (display_->shown != Shown::kDifference) return;
    for (const Difference kind :
         {Difference::kSigned, Difference::kRelative, Difference::kFlip, Difference::kHdrFlip}) {
      if (kind != Difference::kSigned) ImGui::SameLine();
      if (!ImGui::RadioButton(to_string(kind), kind_ == kind)) continue;
      if (kind != kind_) display_->difference = nullptr;  // it has another kind
      kind_ = kind;
      update_tone(frame);
    }
    if (kind_ != Difference::kFlip &&
        ImGui::SliderFloat("range", &range_, 0.001f, 100, "%.3g", ImGuiSliderFlags_Logarithmic)) {
      update_tone(frame);
    }
  }

  void draw_errors() const {
    if (!has_found_) return ImGui::TextDisabled("comparing");
    if (!found_.fault.empty()) return draw_error(found_.fault);
    ImGui::Text("relMSE %.4g, FLIP %.4f", found_.errors.rel_mse, found_.flip);
    ImGui::TextDisabled("largest value of the relMSE %.4g", found_.errors.largest);
    if (found_.errors.left_out > 0) {
      ImGui::TextColored(
          kErrorColor, "%s left out: not finite",
          counted(static_cast<double>(found_.errors.left_out), "pixel").c_str());
    }
  }

  void set_reference(Frame& frame, std::shared_ptr<const Reference> reference) {
    display_->reference = std::move(reference);
    display_->difference = nullptr;
    display_->shown = display_->reference ? Shown::kSplit : Shown::kPicture;
    has_found_ = false;
    fault_.clear();
    frame.view.refresh();
  }

  /// Compares the image in another thread, and takes the result of a finished comparison. With
  /// unchanged settings it compares once a second at most.
  void follow(Frame& frame) {
    using std::chrono::steady_clock;
    if (running_.valid()) {
      if (running_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
      found_ = running_.get();
      // The user may have selected another reference or kind in the meantime.
      has_found_ = compared_reference_ == display_->reference;
      if (has_found_ && compared_kind_ == kind_) {
        display_->difference = found_.difference;
        update_tone(frame);
      }
    }
    const PicturePointer& picture = frame.picture;
    if (!display_->reference || !picture || picture->is_preview) return;
    const bool is_other = compared_reference_ != display_->reference || compared_kind_ != kind_ ||
                          !(compared_tone_ == display_->tone);
    if (!is_other && compared_generation_ == picture->generation) return;
    if (!is_other && steady_clock::now() - compared_at_ < kMinCompareInterval) return;
    compared_generation_ = picture->generation;
    compared_kind_ = kind_;
    compared_tone_ = display_->tone;
    compared_reference_ = display_->reference;
    compared_at_ = steady_clock::now();
    running_ = std::async(std::launch::async, [picture, reference = display_->reference,
                                               kind = kind_, tone = display_->tone] {
      return compare(picture->image, *reference, kind, tone);
    });
  }

  void update_tone(Frame& frame) {
    display_->difference_tone = tone_of(kind_, range_);
    frame.view.refresh();
  }

  /// Returns the x coordinate of the split line in the window.
  float split_at(const Frame& frame) const {
    const PictureArea& area = frame.view.area();
    return area.corner.x + area.scale * display_->split * static_cast<float>(area.crop.width());
  }

  std::shared_ptr<Display> display_;
  FilePicker picker_;
  char path_[512] = {};
  std::string fault_;
  Difference kind_ = Difference::kRelative;
  float range_ = 1;
  std::future<Comparison> running_;
  Comparison found_;
  bool has_found_ = false;
  /// Input and start time of the comparison that is running or was the last.
  uint64_t compared_generation_ = 0;
  Difference compared_kind_ = Difference::kRelative;
  Tone compared_tone_;
  std::shared_ptr<const Reference> compared_reference_;
  std::chrono::steady_clock::time_point compared_at_;
};

}  // namespace

std::unique_ptr<Panel> make_compare_panel(std::shared_ptr<Display> display) {
  return std::make_unique<ComparePanel>(std::move(display));
}

}  // namespace kinome::viewer
