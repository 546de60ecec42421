#include "window/viewer_window.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "kinome/image_files.h"
#include "kinome/color.h"
#include "kinome/error.h"
#include "panels/widgets.h"

namespace kinome::viewer {
namespace {

/// Width of the side bar at a content scale of 1 [pixels].
constexpr float kSideBarWidth = 380;
/// Locations of DejaVu Sans in Debian, Fedora, Arch and openSUSE. ImGui's own font replaces it.
constexpr const char* kFonts[] = {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                  "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
                                  "/usr/share/fonts/TTF/DejaVuSans.ttf",
                                  "/usr/share/fonts/truetype/DejaVuSans.ttf"};
/// Number of frames to draw after input, until ImGui's layout is stable. A new image needs only
/// one.
constexpr int kFramesAfterInput = 3;
/// Minimum time between two frames without input, which update displayed values [s].
constexpr double kIdleInterval = 0.25;
/// Maximum time of such frames as a fraction of the whole. Without a graphics processor, the render
/// waits for them.
constexpr double kMaxIdleShare = 0.04;
/// Time between two frames of a flight [s].
constexpr double kFlightInterval = 0.02;
/// Speed of a flight, in distances to the target per second.
constexpr float kFlightSpeed = 0.7f;

std::string& glfw_fault() {
  static std::string text;
  return text;
}

/// Loads the font and scales all widgets.
void set_style(float scale) {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.FrameRounding = style.GrabRounding = style.PopupRounding = 3;
  style.ScaleAllSizes(scale);
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  const float size = std::round(kFontSize * scale);
  for (const char* const file : kFonts) {
    std::error_code fault;
    if (!std::filesystem::is_regular_file(file, fault)) continue;
    if (fonts.AddFontFromFileTTF(file, size)) return;
  }
  ImFontConfig config;
  config.SizePixels = size;
  fonts.AddFontDefault(&config);
}

}  // namespace

ViewerWindow::ViewerWindow(Options options) : options_(std::move(options)) {
  glfwSetErrorCallback([](int, const char* text) { glfw_fault() = text; });
  if (!glfwInit()) throw Error("no window can be opened: " + glfw_fault());
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  window_ =
      glfwCreateWindow(options_.width, options_.height, options_.title.c_str(), nullptr, nullptr);
  if (!window_) {
    glfwTerminate();
    throw Error("no window can be opened: " + glfw_fault());
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  // Installed before ImGui's callbacks, which call these.
  glfwSetKeyCallback(window_, on_key);
  glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned) { on_input(window); });
  glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
    on_input(window);
    window_of(window).cursor_ = Vec2(x, y);
  });
  glfwSetCursorEnterCallback(window_, [](GLFWwindow* window, int) { on_input(window); });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int, int action, int) {
    on_input(window);
    ViewerWindow& self = window_of(window);
    if (action == GLFW_PRESS && !self.pressed_at_) self.pressed_at_ = self.cursor_;
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* window, double, double) { on_input(window); });
  glfwSetWindowFocusCallback(window_, [](GLFWwindow* window, int) { on_input(window); });
  glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** files) {
    on_input(window);
    for (int i = 0; i < count; ++i) window_of(window).drop(files[i]);
  });
  glfwSetWindowRefreshCallback(window_, on_input);
  glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* window, int, int) { on_input(window); });
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  float scale = 1, vertical = 1;
  glfwGetWindowContentScale(window_, &scale, &vertical);
  scale_ = std::max(1.f, scale);
  set_style(scale_);
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
  view_ = std::make_unique<PictureView>();
  panels_ = make_panels();
}

ViewerWindow::~ViewerWindow() {
  panels_.clear();
  view_.reset();
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void ViewerWindow::wake() {
  glfwPostEmptyEvent();
}

/// Opens a dropped scene, or compares with a dropped image.
void ViewerWindow::drop(const std::string& file) {
  if (std::filesystem::path(file).extension() == ".xml") {
    session_->open(file);
  } else {
    reference_ = file;
  }
}

void ViewerWindow::show_title(const Frame& frame) {
  if (!frame.info || frame.info->file == shown_file_) return;
  const bool is_first = std::exchange(shown_file_, frame.info->file).empty();
  if (!is_first) {
    selection_.reset();
    camera_ = {};
  }
  glfwSetWindowTitle(window_, (shown_file_ + " - kinome-view").c_str());
}

ViewerWindow& ViewerWindow::window_of(GLFWwindow* window) {
  return *static_cast<ViewerWindow*>(glfwGetWindowUserPointer(window));
}

void ViewerWindow::on_input(GLFWwindow* window) {
  window_of(window).frames_wanted_ = kFramesAfterInput;
}

void ViewerWindow::on_key(GLFWwindow* window, int key, int, int action, int mods) {
  on_input(window);
  ViewerWindow& self = window_of(window);
  // Ctrl+S must not fly, no matter which of the two keys is released first.
  if (action == GLFW_RELEASE) self.held_.erase(key);
  if (action == GLFW_PRESS && key == GLFW_KEY_F12) self.wants_screenshot_ = true;
  if (action != GLFW_PRESS || ImGui::GetIO().WantTextInput) return;
  if ((mods & GLFW_MOD_CONTROL) == 0) {
    if (key == GLFW_KEY_F) self.view_->reset_zoom();
    if (key == GLFW_KEY_ESCAPE && self.session_->status().region) {
      self.session_->set_region(std::nullopt);
    }
    if (key >= GLFW_KEY_1 && key <= GLFW_KEY_9) self.tabs_.select(key - GLFW_KEY_1);
    self.held_.insert(key);
    return;
  }
  if (key == GLFW_KEY_R) self.session_->reload();
  if (key == GLFW_KEY_S) self.wants_save_ = true;
  if (key == GLFW_KEY_O) self.wants_open_ = true;
  if (key == GLFW_KEY_K) self.tabs_.keep_displayed(self.session_->picture());
  if (key == GLFW_KEY_Z) self.session_->undo();
  if (key == GLFW_KEY_Q) glfwSetWindowShouldClose(window, GLFW_TRUE);
}

void ViewerWindow::run(RenderSession& session) {
  session_ = &session;
  frames_wanted_ = kFramesAfterInput;
  glfwShowWindow(window_);
  // A save that was requested before the window was closed still needs a frame.
  while (!glfwWindowShouldClose(window_) || wants_save_) {
    const auto start = std::chrono::steady_clock::now();
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    // Before version 1.87, ImGui takes the position of this frame for that of the press, although
    // the mouse may have moved on.
    if (pressed_at_) ImGui::GetIO().MousePos = {pressed_at_->x, pressed_at_->y};
    pressed_at_.reset();
    ImGui::NewFrame();
    Frame frame{session,
                *view_,
                camera_,
                tabs_,
                lights_,
                shown_picture(),
                session.info(),
                session.status(),
                selection_,
                std::exchange(wants_save_, false),
                std::exchange(wants_open_, false),
                std::exchange(reference_, {})};
    show_title(frame);
    camera_.follow(session, frame.info);
    fly(frame);
    draw(frame);
    ImGui::Render();
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    glViewport(0, 0, width, height);
    glClearColor(0.1f, 0.1f, 0.1f, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    if (std::exchange(wants_screenshot_, false)) take_screenshot(session);
    glfwSwapBuffers(window_);
    if (options_.trace) trace(frame);
    if (is_flying_) {
      glfwWaitEventsTimeout(kFlightInterval);
    } else if (--frames_wanted_ > 0) {
      glfwPollEvents();
    } else {
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
      glfwWaitEventsTimeout(std::max(kIdleInterval, seconds.count() / kMaxIdleShare));
    }
  }
  if (options_.trace) {
    std::printf("closed\n");
    std::fflush(stdout);
  }
  glfwHideWindow(window_);
  glfwPollEvents();
}

void ViewerWindow::draw(Frame& frame) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                      ImGuiWindowFlags_NoBringToFrontOnFocus;
  const float side = std::min(kSideBarWidth * scale_, 0.5f * size.x);
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({size.x - side, size.y});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::Begin("picture", nullptr,
               kFixed | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse |
                   ImGuiWindowFlags_NoBackground);
  ImGui::PopStyleVar(2);
  draw_picture(frame);
  ImGui::End();
  ImGui::SetNextWindowPos({size.x - side, 0});
  ImGui::SetNextWindowSize({side, size.y});
  ImGui::Begin("panels", nullptr, kFixed);
  draw_side_bar(frame);
  ImGui::End();
}

void ViewerWindow::draw_picture(Frame& frame) {
  tabs_.draw();
  frame.picture = shown_picture();
  frame.view.draw(frame.picture);
  for (const auto& panel : panels_) panel->draw_over_picture(frame);
  mouse_.update(frame, panels_);
}

void ViewerWindow::draw_side_bar(Frame& frame) {
  // Leaves room for the names to the right of the widgets.
  ImGui::PushItemWidth(-150 * scale_);
  for (const auto& panel : panels_) {
    const auto flags = panel->is_open_at_first() ? ImGuiTreeNodeFlags_DefaultOpen : 0;
    if (!ImGui::CollapsingHeader(panel->title(), flags)) continue;
    ImGui::PushID(panel.get());
    panel->draw(frame);
    ImGui::PopID();
  }
  ImGui::PopItemWidth();
}

/// Moves the camera by the keys that are held.
void ViewerWindow::fly(Frame& frame) {
  const auto now = std::chrono::steady_clock::now();
  const float seconds = std::chrono::duration<float>(now - last_frame_).count();
  last_frame_ = now;
  const auto pressed = [&](int key) { return held_.count(key) ? 1.f : 0.f; };
  const Vec3 way(pressed(GLFW_KEY_D) - pressed(GLFW_KEY_A),
                 pressed(GLFW_KEY_E) - pressed(GLFW_KEY_Q),
                 pressed(GLFW_KEY_W) - pressed(GLFW_KEY_S));
  const bool was_flying = is_flying_;
  is_flying_ = way != Vec3(0.f) && frame.camera.can_move() && tabs_.is_live() &&
               !ImGui::GetIO().WantTextInput;
  if (!is_flying_) return;
  // The previous frame may have been long ago.
  const float step = was_flying ? std::min(seconds, 0.25f) : static_cast<float>(kFlightInterval);
  const Vec3 length = way * step * kFlightSpeed * frame.camera.controls().distance();
  frame.camera.controls().move(length.x, length.y, length.z);
  frame.camera.send(frame.session);
}

void ViewerWindow::take_screenshot(RenderSession& session) {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  std::vector<uint8_t> bytes(3 * static_cast<size_t>(width) * height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
  Image image{width, height, {"R", "G", "B"}, std::vector<float>(bytes.size())};
  const size_t row = 3 * static_cast<size_t>(width);
  for (size_t i = 0; i < bytes.size(); ++i) {
    // OpenGL's rows start at the bottom.
    const size_t from = (static_cast<size_t>(height) - 1 - i / row) * row + i % row;
    image.data[i] = srgb_to_linear(static_cast<float>(bytes[from]) / 255);
  }
  const std::string file = options_.screenshot.empty() ? "kinome-view.png" : options_.screenshot;
  try {
    write_png(file, image, 0);
    session.say(false, "wrote " + file);
  } catch (const std::exception& fault) {
    session.say(true, fault.what());
  }
}

/// Prints a line for each new image, message and selection, for tests and measurements.
void ViewerWindow::trace(const Frame& frame) {
  const double now =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - options_.start).count();
  if (!std::exchange(has_traced_window_, true)) std::printf("%.3f window\n", now);
  for (const Message& message : frame.session.messages(traced_messages_)) {
    std::printf("%.3f %s %s\n", now, message.is_error ? "error" : "note", message.text.c_str());
    traced_messages_ = message.number;
  }
  if (selection_ != traced_selection_) {
    traced_selection_ = selection_;
    std::printf("%.3f selected", now);
    if (selection_) {
      for (const std::string& path : selection_->materials) std::printf(" %s", path.c_str());
    }
    std::printf("\n");
  }
  const PicturePointer& picture = frame.picture;
  if (picture && picture->generation != traced_generation_) {
    traced_generation_ = picture->generation;
    uint64_t rays = 0;
    for (const uint64_t of_kind : picture->stats.counters.rays) rays += of_kind;
    std::printf("%.3f picture %llu edition %llu %dx%d %s %.0f samples %.3f s relmse %.3g rays %llu\n",
                now,
                static_cast<unsigned long long>(picture->generation),
                static_cast<unsigned long long>(picture->edition), picture->image.width,
                picture->image.height,
                picture->is_preview ? "preview"
                : picture->is_part  ? "part"
                : picture->is_final ? "final"
                                    : "pass",
                picture->samples, picture->seconds, picture->rel_mse,
                static_cast<unsigned long long>(rays));
  }
  std::fflush(stdout);
}

}  // namespace kinome::viewer
