#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <string>

#include "panels/panel.h"
#include "picture/display.h"

namespace kinome::viewer {

/// Comparison of the image with a reference from a file, or with an earlier state of the image.
/// Shows them side by side, or their difference, and reports relMSE and FLIP.
class ComparePanel final : public Panel {
 public:
  explicit ComparePanel(std::shared_ptr<Display> display) : display_(std::move(display)) {}
  const char* title() const override { return "Compare"; }
  void draw(Frame& frame) override;
  void draw_over_picture(Frame& frame) override;
  /// Starts a drag of the line between the image and the reference.
  bool press(Frame& frame, const PictureClick& click) override;
  void drag(Frame& frame, const Vec2& film) override;

 private:
  void draw_reference(Frame& frame);
  void draw_shown(Frame& frame);
  void draw_errors() const;
  void set_reference(Frame& frame, std::shared_ptr<const Reference> reference);
  /// Compares the image in another thread, and takes the result of a finished comparison. With
  /// unchanged settings it compares once a second at most.
  void follow(Frame& frame);
  void update_tone(Frame& frame);
  /// Returns the x coordinate of the split line in the window.
  float split_at(const Frame& frame) const;

  std::shared_ptr<Display> display_;
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

}  // namespace kinome::viewer
