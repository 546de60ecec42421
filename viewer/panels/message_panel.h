#pragma once

#include <deque>

#include "panels/panel.h"

namespace kinome::viewer {

/// What went wrong, and what else there is to know, the latest first.
class MessagePanel final : public Panel {
 public:
  const char* title() const override { return "Messages"; }
  bool is_open_at_first() const override { return true; }
  void draw(Frame& frame) override;
  /// An error, until it is clicked away or something else is told.
  void draw_over_picture(Frame& frame) override;

 private:
  void read(const Frame& frame);

  std::deque<Message> known_;
  uint64_t seen_ = 0;  ///< number of the last one that was clicked away
};

}  // namespace kinome::viewer
