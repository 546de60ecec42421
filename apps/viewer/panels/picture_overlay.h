#pragma once

#include <optional>

#include "picture/display.h"
#include "session/picture.h"
#include "window/picture_view.h"

namespace kinome::viewer {

/// A pixel of an image. A preview has fewer pixels than the film.
struct ImagePixel {
  int x, y;
};
/// Returns the pixel at a position on the film, or nullopt if the position is outside the image.
std::optional<ImagePixel> pixel_at(const Picture& picture, const PictureArea& area,
                                   const Vec2& film);

/// Draws a grid between the pixels if they are large, and their values if there is room for them.
/// Draws into the current ImGui window.
void draw_pixel_values(const Picture& picture, const PictureArea& area, const Tone& tone);

/// Draws the legend of a colour map at the lower edge of the image.
void draw_color_legend(const PictureArea& area, const Tone& tone, const char* text);

}  // namespace kinome::viewer
