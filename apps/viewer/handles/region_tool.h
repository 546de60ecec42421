#pragma once

#include <optional>

#include "panels/panel.h"

namespace kinome::viewer {

/// Selects the region of the image that is rendered on, by a drag with Ctrl and Shift. For the
/// window's thread only.
class RegionTool {
 public:
  /// Draws the border of the region, and darkens the rest of the image while it is dragged.
  void draw(const Frame& frame) const;
  bool press(const PictureClick& click);
  void drag(const Vec2& film) { end_ = film; }
  /// Sets the region of the session, or removes it after a press without a drag.
  void release(Frame& frame);

 private:
  /// Returns the pixels between the corners of the drag.
  Rect dragged() const;

  std::optional<Vec2> start_;  ///< corner of a drag on the film; nullopt if there is no drag
  Vec2 end_{0.f};
};

}  // namespace kinome::viewer
