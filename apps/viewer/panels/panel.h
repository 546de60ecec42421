#pragma once

#include <memory>
#include <string>

#include "camera/camera_link.h"
#include "picture/light_sliders.h"
#include "session/render_session.h"
#include "window/picture_tabs.h"
#include "window/picture_view.h"

namespace kinome::viewer {

/// State of the viewer that panels can use and change while a frame is drawn.
struct Frame {
  RenderSession& session;
  PictureView& view;
  CameraLink& camera;
  PictureTabs& tabs;
  LightSliders& lights;                   ///< change the light of `picture`
  PicturePointer picture;                 ///< displayed image; nullptr if there is none yet
  std::shared_ptr<const SceneInfo> info;  ///< nullptr if the scene is not loaded yet
  Status status;
  /// Surface that was clicked on last; nullptr if there is none.
  std::shared_ptr<const Pick>& selection;
  bool wants_save = false;  ///< Ctrl+S was pressed
  bool wants_open = false;  ///< Ctrl+O was pressed
  std::string reference{};  ///< image file that was dropped on the window, or ""
};

/// Press of a mouse button over the image, with the keys that were held. Panel::click() gets it
/// after the button is released without a drag.
struct PictureClick {
  Vec2 film{0.f};  ///< position [pixels of the full film]
  int button = 0;  ///< 0 is the left button
  bool alt = false, ctrl = false, shift = false;
};

/// A section of the side bar, with a heading that opens and closes it. A panel can also draw over
/// the image. The window's thread calls all functions.
class Panel {
 public:
  Panel() = default;
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
  virtual ~Panel() = default;

  virtual const char* title() const = 0;
  virtual bool is_open_at_first() const { return false; }
  /// Draws the ImGui widgets. Called in each frame while the panel is open.
  virtual void draw(Frame& frame) = 0;
  /// Draws over the image, into the current ImGui window. Called in each frame.
  virtual void draw_over_picture(Frame& /*frame*/) {}
  /// Handles a click. Returns true if the click was used: then later panels don't get it, and it
  /// doesn't select a surface.
  virtual bool click(Frame& /*frame*/, const PictureClick& /*click*/) { return false; }
  /// Returns true to receive the drag that this press starts, by calls of drag(). Then the press
  /// isn't a click. Otherwise the drag moves the camera.
  virtual bool press(Frame& /*frame*/, const PictureClick& /*click*/) { return false; }
  virtual void drag(Frame& /*frame*/, const Vec2& /*film*/) {}
  /// Called when the button of such a press is released.
  virtual void release(Frame& /*frame*/) {}
};

/// Returns all panels in the order of the side bar. Add new panels to the list in panels.cpp.
std::vector<std::unique_ptr<Panel>> make_panels();

// The panels, each of which is a class in a file of its own.
struct Display;
std::unique_ptr<Panel> make_camera_panel();
std::unique_ptr<Panel> make_compare_panel(std::shared_ptr<Display> display);
std::unique_ptr<Panel> make_environment_panel();
std::unique_ptr<Panel> make_inspector_panel();
std::unique_ptr<Panel> make_lamp_panel();
std::unique_ptr<Panel> make_light_panel();
std::unique_ptr<Panel> make_material_panel();
std::unique_ptr<Panel> make_medium_panel();
std::unique_ptr<Panel> make_message_panel();
std::unique_ptr<Panel> make_parameter_panel();
std::unique_ptr<Panel> make_render_panel();
std::unique_ptr<Panel> make_save_panel();
std::unique_ptr<Panel> make_tone_panel(std::shared_ptr<Display> display);

}  // namespace kinome::viewer
