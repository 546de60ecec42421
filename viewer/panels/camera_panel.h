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
  void draw_over_picture(Frame& frame) override;

 private:
  std::shared_ptr<const PickAnswer> focus_;  ///< what is to be focused on
};

}  // namespace kinome::viewer
