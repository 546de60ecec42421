#pragma once

#include "panels/panel.h"

namespace kinome::viewer {

/// Position of the camera, reset, <lookat> for the clipboard, and focus of a thin lens.
class CameraPanel final : public Panel {
 public:
  const char* title() const override { return "Camera"; }
  void draw(Frame& frame) override;
  /// With Ctrl, focuses a thin lens on the surface under the mouse.
  bool click(Frame& frame, const PictureClick& click) override;
  void draw_over_picture(Frame& frame) override;

 private:
  std::shared_ptr<const PickAnswer> focus_;  ///< surface to focus on; nullptr if none is requested
};

}  // namespace kinome::viewer
