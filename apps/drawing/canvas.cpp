#include "drawing/canvas.h"

#include "drawing/small_font.h"

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

int Canvas::text(int x, int y, int scale, const std::string& text, const Rgb& color) {
  for (const char c : text) {
    for (int j = 0; j < kGlyphHeight; ++j) {
      for (int i = 0; i < kGlyphWidth; ++i) {
        if (!has_ink(c, i, j)) continue;
        const int left = x + i * scale, top = y + j * scale;
        fill({left, top, left + scale, top + scale}, color);
      }
    }
    x += kGlyphWidth * scale;
  }
  return x;
}

void Canvas::extend(int rows) {
  image.height += rows;
  image.data.resize(static_cast<size_t>(image.width) * image.height * 3);
}

}  // namespace kinome::drawing
