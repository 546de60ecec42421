#pragma once

#include "panels/panel.h"

namespace kinome::viewer {

/// Mouse input over the image: clicks, drags and the wheel.
class PictureMouse {
 public:
  /// Must be called while the image's ImGui window is current, after everything else is drawn in
  /// it.
  void update(Frame& frame, const std::vector<std::unique_ptr<Panel>>& panels);

 private:
  void press(Frame& frame, const std::vector<std::unique_ptr<Panel>>& panels, int button);
  void release(Frame& frame, const std::vector<std::unique_ptr<Panel>>& panels);
  void drag(Frame& frame);
  void turn_wheel(Frame& frame);
  void take_selection(Frame& frame);

  int button_ = -1;  ///< button that was pressed over the image and is held; -1 if none
  bool is_drag_ = false;
  Panel* drag_panel_ = nullptr;  ///< panel that receives the drag; nullptr for the camera
  Vec2 pressed_at_{0.f};
  PictureClick pressed_;
  std::shared_ptr<const PickAnswer> selecting_;
};

}  // namespace kinome::viewer
