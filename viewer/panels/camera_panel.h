#pragma once

#include "panels/panel.h"

namespace kinome::viewer {

/// Where the camera is; reset, its <lookat> for the clipboard, and the focus of a thin lens.
class CameraPanel final : public Panel {
 public:
  const char* title() const override { return "Camera"; }
  void draw(Frame& frame) override;
  /// With Ctrl: focuses a thin lens on what was clicked on.
  bool click(Frame& frame, const PictureClick& click) override;
};

}  // namespace kinome::viewer
