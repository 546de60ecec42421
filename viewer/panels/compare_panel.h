#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <string>

#include "panels/panel.h"
#include "picture/display.h"

namespace kinome::viewer {

/// The picture against a reference from a file, or against itself as it was: beside each other, or
/// what they differ by; with relMSE and FLIP.
class ComparePanel final : public Panel {
 public:
  explicit ComparePanel(std::shared_ptr<Display> display) : display_(std::move(display)) {}
  const char* title() const override { return "Compare"; }
  void draw(Frame& frame) override;
  void draw_over_picture(Frame& frame) override;
  /// Of the line between the two.
  bool press(Frame& frame, const PictureClick& click) override;
  void drag(Frame& frame, const Vec2& film) override;

 private:
  void draw_reference(Frame& frame);
  void draw_shown(Frame& frame);
  void draw_errors() const;
  void set_reference(Frame& frame, std::shared_ptr<const Reference> reference);
  /// Has the picture compared by another thread, not more often than once a second, and takes what
  /// that has found.
  void follow(Frame& frame);
  void update_tone(Frame& frame);
  float split_at(const Frame& frame) const;  ///< in the window

  std::shared_ptr<Display> display_;
  char path_[512] = {};
  std::string fault_;
  Difference kind_ = Difference::kRelative;
  float range_ = 1;
  std::future<Comparison> running_;
  Comparison found_;
  bool has_found_ = false;
  /// What the comparison that runs, or ran last, is of.
  uint64_t asked_generation_ = 0;
  Difference asked_kind_ = Difference::kRelative;
  Tone asked_tone_;
  std::shared_ptr<const Reference> asked_reference_;
  std::chrono::steady_clock::time_point asked_at_;
};

}  // namespace kinome::viewer
