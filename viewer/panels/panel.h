#pragma once

#include <memory>

#include "camera/camera_link.h"
#include "session/render_session.h"
#include "window/picture_view.h"

namespace kinome::viewer {

/// What panels see of the viewer while a frame is drawn, and what they may change.
struct Frame {
  RenderSession& session;
  PictureView& view;
  CameraLink& camera;
  PicturePointer picture;                 ///< nullptr: there is none yet
  std::shared_ptr<const SceneInfo> info;  ///< nullptr: the scene is not loaded yet
  Status status;
  /// What was clicked on last; nullptr: nothing, or nothing that is there any more.
  std::shared_ptr<const Pick>& selection;
  bool wants_save = false;  ///< Ctrl+S was pressed
};

/// A mouse button was pressed over the picture, with these keys held; for Panel::click(), it was
/// released again without a drag.
struct PictureClick {
  Vec2 film{0.f};  ///< position [pixels of the full film]
  int button = 0;  ///< 0: left
  bool alt = false, ctrl = false, shift = false;
};

/// A part of the side bar, beneath a heading that opens and closes it; what it shows may also be
/// drawn over the picture. All of its functions are called by the thread of the window.
class Panel {
 public:
  Panel() = default;
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
  virtual ~Panel() = default;

  virtual const char* title() const = 0;
  virtual bool is_open_at_first() const { return false; }
  /// Its widgets, by ImGui; called while it is open.
  virtual void draw(Frame& frame) = 0;
  /// Draws over the picture, into the current ImGui window; called in each frame.
  virtual void draw_over_picture(Frame& /*frame*/) {}
  /// Whether it takes a click: panels are asked in their order, before the click selects a surface.
  virtual bool click(Frame& /*frame*/, const PictureClick& /*click*/) { return false; }
  /// Whether it takes what a pressed button will drag, in place of the camera: drag() follows.
  virtual bool press(Frame& /*frame*/, const PictureClick& /*click*/) { return false; }
  virtual void drag(Frame& /*frame*/, const Vec2& /*film*/) {}
};

/// In the order of the side bar. A new one is added to the list in panels.cpp.
std::vector<std::unique_ptr<Panel>> make_panels();

}  // namespace kinome::viewer
