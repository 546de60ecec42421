#pragma once

#include <functional>
#include <vector>

#include "session/picture.h"
#include "window/image_texture.h"

namespace kinome::viewer {

/// Position of the image in the window. Window positions are ImGui's.
struct PictureArea {
  Vec2 corner{0.f};          ///< upper left corner of the crop window, in the window
  float scale = 1;           ///< pixels of the window per pixel of the film
  Rect crop;                 ///< crop window of the film
  Vec2 low{0.f}, high{0.f};  ///< part of the window that is reserved for the image

  /// Positions on the film, in pixels; (0, 0) is the upper left corner of the full film.
  Vec2 to_film(const Vec2& window) const {
    return (window - corner) / scale + Vec2(crop.x0, crop.y0);
  }
  Vec2 to_window(const Vec2& film) const {
    return (film - Vec2(crop.x0, crop.y0)) * scale + corner;
  }
  bool shows(const Vec2& film) const {
    return film.x >= static_cast<float>(crop.x0) && film.x < static_cast<float>(crop.x1) &&
           film.y >= static_cast<float>(crop.y0) && film.y < static_cast<float>(crop.y1);
  }
};

/// Converts an image to display pixels of the same number: 8-bit sRGB with R, G, B and A, rows from
/// top to bottom.
using ToneFunction = std::function<void(const Picture& picture, std::vector<uint8_t>& rgba)>;

/// Displays an image with zoom and offset. For the thread of the OpenGL context only.
class PictureView {
 public:
  /// Replaces the default tone mapping, plain sRGB (nullptr), and converts the image again.
  void set_tone(ToneFunction tone);
  /// Converts the image again. Call it when the settings of the ToneFunction have changed.
  void refresh() { shown_generation_ = 0; }

  /// Draws the image into the current ImGui window, filling it. Draws nothing for nullptr.
  void draw(const PicturePointer& picture);
  /// Returns the area of the last draw().
  const PictureArea& area() const { return area_; }
  /// Multiplies the zoom by a factor, keeping the point at this window position fixed. At zoom 1
  /// the whole image is visible.
  void zoom(float factor, const Vec2& window_position);
  void move(const Vec2& window_offset) { offset_ += window_offset; }
  void reset_zoom() { zoom_ = 1, offset_ = Vec2(0.f); }

 private:
  void upload(const Picture& picture);
  void place(const Rect& crop);

  ToneFunction tone_;
  ImageTexture texture_;
  uint64_t shown_generation_ = 0;
  std::vector<uint8_t> rgba_;
  PictureArea area_;
  float zoom_ = 1;
  Vec2 offset_{0.f};
};

}  // namespace kinome::viewer
