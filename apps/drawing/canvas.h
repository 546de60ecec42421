#pragma once

#include <string>

#include "kinome/color.h"
#include "kinome/image.h"

namespace kinome::drawing {

/// Image to draw into. All functions except set() clip to the image.
struct Canvas {
  Image image;
  Canvas(int width, int height) : image{width, height, {"R", "G", "B"}, {}} {
    image.data.resize(static_cast<size_t>(width) * height * 3);
  }
  bool holds(int x, int y) const { return x >= 0 && y >= 0 && x < image.width && y < image.height; }
  void set(int x, int y, const Rgb& color) {
    for (int c = 0; c < 3; ++c) image.at(x, y, c) = color[c];
  }
  void disk(const Vec2& centre, float radius, const Rgb& color);
  /// Fills pixels [x0, x1) x [y0, y1).
  void fill(const Rect& pixels, const Rgb& color);
  void frame(const Rect& pixels, const Rgb& color);
  /// Draws a line of ASCII characters, enlarged `scale` times, with its upper left corner at (x,
  /// y).
  void text(int x, int y, int scale, std::string text, const Rgb& color);
  /// Adds rows at the bottom.
  void extend(int rows);
};

}  // namespace kinome::drawing
