#pragma once

#include <functional>
#include <vector>

#include "session/picture.h"

namespace kinome::viewer {

/// Where the picture is in the window, and what is where in it. Window positions are ImGui's.
struct PictureArea {
  Vec2 corner{0.f};          ///< of the film's crop window, in the window
  float scale = 1;           ///< pixels of the window for each pixel of the film
  Rect crop;                 ///< of the film
  Vec2 low{0.f}, high{0.f};  ///< the part of the window that pictures may cover

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

/// Turns a picture into what is shown: R, G, B and A of 8 bits, sRGB, rows from top to bottom, as
/// many pixels as its image has.
using ToneFunction = std::function<void(const Picture& picture, std::vector<uint8_t>& rgba)>;

/// Shows pictures, zoomed and moved. Of the thread that has the OpenGL context.
class PictureView {
 public:
  PictureView();
  ~PictureView();
  PictureView(const PictureView&) = delete;
  PictureView& operator=(const PictureView&) = delete;

  /// In place of sRGB without more ado. The picture is converted anew.
  void set_tone(ToneFunction tone);
  /// Converts it anew: when what the ToneFunction depends on has changed.
  void refresh() { shown_generation_ = 0; }

  /// Draws the picture into the current ImGui window, over all of its contents; nullptr: nothing.
  void draw(const PicturePointer& picture);
  /// As it was drawn last.
  const PictureArea& area() const { return area_; }
  /// By a factor, such that what is at this place of the window stays there. At zoom 1 all of the
  /// picture is seen.
  void zoom(float factor, const Vec2& window_position);
  void move(const Vec2& window_offset) { offset_ += window_offset; }
  void reset_zoom() { zoom_ = 1, offset_ = Vec2(0.f); }

 private:
  void upload(const Picture& picture);
  void place(const Rect& crop);

  ToneFunction tone_;
  unsigned texture_ = 0;
  uint64_t shown_generation_ = 0;
  std::vector<uint8_t> rgba_;
  PictureArea area_;
  float zoom_ = 1;
  Vec2 offset_{0.f};
};

}  // namespace kinome::viewer
