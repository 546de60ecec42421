#include "drawing/canvas.h"

#include <array>

#include <stb_easy_font.h>

namespace kinome::drawing {

void Canvas::disk(const Vec2& centre, float radius, const Rgb& color) {
  for (int y = static_cast<int>(centre.y - radius); y <= static_cast<int>(centre.y + radius); ++y) {
    for (int x = static_cast<int>(centre.x - radius); x <= static_cast<int>(centre.x + radius);
         ++x) {
      const Vec2 d(static_cast<float>(x) + 0.5f - centre.x,
                   static_cast<float>(y) + 0.5f - centre.y);
      if (holds(x, y) && glm::dot(d, d) <= radius * radius) set(x, y, color);
    }
  }
}

void Canvas::fill(const Rect& pixels, const Rgb& color) {
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      if (holds(x, y)) set(x, y, color);
    }
  }
}

void Canvas::frame(const Rect& pixels, const Rgb& color) {
  const Rect& r = pixels;
  fill({r.x0, r.y0, r.x1, r.y0 + 1}, color);
  fill({r.x0, r.y1 - 1, r.x1, r.y1}, color);
  fill({r.x0, r.y0, r.x0 + 1, r.y1}, color);
  fill({r.x1 - 1, r.y0, r.x1, r.y1}, color);
}

void Canvas::text(int x, int y, int scale, std::string text, const Rgb& color) {
  // The library draws a character by at most 11 rectangles, and returns their four corners.
  std::vector<std::array<glm::vec4, 4>> boxes(11 * text.size());
  const int count = stb_easy_font_print(0, 0, text.data(), nullptr, boxes.data(),
                                        static_cast<int>(boxes.size() * sizeof boxes.front()));
  for (int i = 0; i < count; ++i) {
    const glm::ivec2 low(boxes[i][0]), high(boxes[i][2]);
    fill({x + scale * low.x, y + scale * low.y, x + scale * high.x, y + scale * high.y}, color);
  }
}

void Canvas::extend(int rows) {
  image.height += rows;
  image.data.resize(static_cast<size_t>(image.width) * image.height * 3);
}

}  // namespace kinome::drawing
