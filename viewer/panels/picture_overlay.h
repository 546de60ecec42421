#pragma once

#include <optional>

#include "picture/display.h"
#include "session/picture.h"
#include "window/picture_view.h"

namespace kinome::viewer {

/// A pixel of an image, which may have fewer than the film: a preview's.
struct ImagePixel {
  int x, y;
};
/// The one at a position on the film; nullopt: none.
std::optional<ImagePixel> pixel_at(const Picture& picture, const PictureArea& area,
                                   const Vec2& film);

/// Into the current ImGui window: between the pixels a grid where they are large, and in them their
/// values where there is room for these.
void draw_pixel_values(const Picture& picture, const PictureArea& area, const Tone& tone);

/// Which colour stands for which number, at the lower edge of the picture.
void draw_color_legend(const PictureArea& area, const Tone& tone, const char* text);

}  // namespace kinome::viewer
