#pragma once

#include <deque>

#include "panels/panel.h"

namespace kinome::viewer {

/// Errors, warnings and notes, the latest first.
class MessagePanel final : public Panel {
 public:
  const char* title() const override { return "Messages"; }
  bool is_open_at_first() const override { return true; }
  void draw(Frame& frame) override;
  /// Draws the latest message if it is an error that the user hasn't dismissed.
  void draw_over_picture(Frame& frame) override;

 private:
  void read(const Frame& frame);

  std::deque<Message> known_;
  uint64_t seen_ = 0;  ///< number of the last message that was dismissed
};

}  // namespace kinome::viewer
