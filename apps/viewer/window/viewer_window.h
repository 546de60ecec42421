#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "panels/panel.h"
#include "window/picture_mouse.h"
#include "window/relit_picture.h"

struct GLFWwindow;

namespace kinome::viewer {

/// The window, with the image and the panels. For the main thread only, as GLFW requires.
class ViewerWindow {
 public:
  struct Options {
    std::string title;
    int width = 1280, height = 800;
    std::string screenshot;  ///< file that F12 writes; "" for kinome-view.png
    bool trace = false;      ///< prints displayed images and messages to the standard output
    /// Origin of the times in the trace.
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  };

  /// Throws Error if no window can be opened.
  explicit ViewerWindow(Options options);
  ~ViewerWindow();
  ViewerWindow(const ViewerWindow&) = delete;
  ViewerWindow& operator=(const ViewerWindow&) = delete;

  /// Shows the session until the window is closed.
  void run(RenderSession& session);
  /// Makes the window draw a frame. Can be called from any thread while the window exists.
  static void wake();

 private:
  /// Returns the image to display, relit by the sliders.
  PicturePointer shown_picture() {
    return relit_.shown(tabs_.shown(session_->picture()), lights_);
  }
  void draw(Frame& frame);
  void draw_picture(Frame& frame);
  void draw_side_bar(Frame& frame);
  void show_title(const Frame& frame);
  void fly(Frame& frame);
  void take_screenshot(RenderSession& session);
  void trace(const Frame& frame);
  void drop(const std::string& file);
  static ViewerWindow& window_of(GLFWwindow* window);
  static void on_input(GLFWwindow* window);
  static void on_key(GLFWwindow* window, int key, int scancode, int action, int mods);

  Options options_;
  GLFWwindow* window_ = nullptr;
  std::unique_ptr<PictureView> view_;
  std::vector<std::unique_ptr<Panel>> panels_;
  PictureMouse mouse_;
  CameraLink camera_;
  PictureTabs tabs_;
  LightSliders lights_;
  RelitPicture relit_;
  std::shared_ptr<const Pick> selection_;
  RenderSession* session_ = nullptr;  ///< while run() shows it
  bool wants_screenshot_ = false;
  bool wants_save_ = false;
  bool wants_open_ = false;
  std::string reference_;   ///< image file that was dropped on the window
  std::string shown_file_;  ///< scene file in the title
  std::set<int> held_;  ///< held keys that were pressed without Ctrl
  float scale_ = 1;        ///< size of text and widgets, from the display's content scale
  int frames_wanted_ = 0;  ///< number of frames to draw before the next wait
  std::optional<Vec2> cursor_;      ///< position of the mouse in the window
  std::optional<Vec2> pressed_at_;  ///< where a button went down since the last frame
  bool is_flying_ = false;
  std::chrono::steady_clock::time_point last_frame_ = std::chrono::steady_clock::now();
  bool has_traced_window_ = false;
  uint64_t traced_generation_ = 0;
  uint64_t traced_messages_ = 0;
  std::shared_ptr<const Pick> traced_selection_;
};

}  // namespace kinome::viewer
