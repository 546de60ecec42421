#pragma once

#include "panels/panel.h"

namespace kinome::viewer {

/// What the mouse does over the picture: clicks, drags and the wheel.
class PictureMouse {
 public:
  /// Called while the picture's ImGui window is the current one, once all else is drawn into it.
  void update(Frame& frame, const std::vector<std::unique_ptr<Panel>>& panels);

 private:
  void press(Frame& frame, const std::vector<std::unique_ptr<Panel>>& panels, int button);
  void release(Frame& frame, const std::vector<std::unique_ptr<Panel>>& panels);
  void drag(Frame& frame);
  void turn_wheel(Frame& frame);
  void take_selection(Frame& frame);

  int button_ = -1;  ///< that was pressed over the picture and is held
  bool is_drag_ = false;
  Panel* taker_ = nullptr;  ///< of what is dragged; nullptr: the camera
  Vec2 pressed_at_{0.f};
  PictureClick pressed_;  ///< with the keys that were held then
  std::shared_ptr<const PickAnswer> selecting_;
};

}  // namespace kinome::viewer
