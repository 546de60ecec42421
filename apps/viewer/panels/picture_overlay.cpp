#include "panels/picture_overlay.h"

#include <imgui.h>

#include <algorithm>
#include <cstdio>

namespace kinome::viewer {
namespace {

/// Minimum sizes of an image's pixel in the window, for a grid and for its values.
constexpr float kGridScale = 12, kValueScale = 52;
constexpr ImU32 kGridColor = IM_COL32(128, 128, 128, 90);

/// Returns black for bright pixels and white for dark ones.
ImU32 text_color(const uint8_t* rgba) {
  const int brightness = 3 * rgba[0] + 6 * rgba[1] + rgba[2];
  return brightness > 1275 ? IM_COL32(0, 0, 0, 255) : IM_COL32(255, 255, 255, 255);
}

}  // namespace

std::optional<ImagePixel> pixel_at(const Picture& picture, const PictureArea& area,
                                   const Vec2& film) {
  const Image& image = picture.image;
  if (!area.shows(film) || image.width < 1 || image.height < 1) return std::nullopt;
  const Vec2 share =
      (film - Vec2(area.crop.x0, area.crop.y0)) / Vec2(area.crop.width(), area.crop.height());
  return ImagePixel{
      std::min(static_cast<int>(share.x * static_cast<float>(image.width)), image.width - 1),
      std::min(static_cast<int>(share.y * static_cast<float>(image.height)), image.height - 1)};
}

void draw_pixel_values(const Picture& picture, const PictureArea& area, const Tone& tone) {
  const Image& image = picture.image;
  if (picture.is_preview || area.scale < kGridScale || image.width != area.crop.width()) return;
  // Visible part of the image, in pixels.
  const Vec2 low = (area.low - area.corner) / area.scale,
             high = (area.high - area.corner) / area.scale;
  const int x0 = std::max(0, static_cast<int>(low.x)), y0 = std::max(0, static_cast<int>(low.y));
  const int x1 = std::min(image.width, static_cast<int>(high.x) + 1);
  const int y1 = std::min(image.height, static_cast<int>(high.y) + 1);
  if (x0 >= x1 || y0 >= y1) return;
  ImDrawList* const list = ImGui::GetWindowDrawList();
  list->PushClipRect({area.low.x, area.low.y}, {area.high.x, area.high.y}, true);
  const auto at = [&](int x, int y) {
    return ImVec2(area.corner.x + area.scale * static_cast<float>(x),
                  area.corner.y + area.scale * static_cast<float>(y));
  };
  for (int x = x0; x <= x1; ++x) list->AddLine(at(x, y0), at(x, y1), kGridColor);
  for (int y = y0; y <= y1; ++y) list->AddLine(at(x0, y), at(x1, y), kGridColor);
  const ChannelGroup group = group_named(image, tone.group);
  if (area.scale >= kValueScale && group.count > 0) {
    const ToneMapper mapper(tone);
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        uint8_t rgba[4];
        mapper.map(image, {x, y, x + 1, y + 1}, rgba, 4);
        ImVec2 corner = at(x, y);
        corner.x += 3;
        corner.y += 2;
        for (int c = 0; c < group.count; ++c) {
          char text[32];
          std::snprintf(text, sizeof text, "%.3g",
                        static_cast<double>(image.at(x, y, group.index[c])));
          list->AddText(corner, text_color(rgba), text);
          corner.y += ImGui::GetFontSize() + 1;
        }
      }
    }
  }
  list->PopClipRect();
}

void draw_color_legend(const PictureArea& area, const Tone& tone, const char* text) {
  const bool is_signed = tone.curve == Curve::kSigned;
  if (!is_signed && tone.curve != Curve::kFalseColor) return;
  const ColorMap& colors = is_signed ? signed_map() : color_map(tone.map);
  ColorRange range = tone.range;
  if (is_signed) range = {-tone.range.high, tone.range.high, false};
  const float width = std::min(360.f, area.high.x - area.low.x - 60), height = 14;
  if (width < 100) return;
  const Vec2 corner(area.low.x + 28, area.high.y - 44);
  ImDrawList* const list = ImGui::GetWindowDrawList();
  list->AddRectFilled({corner.x - 18, corner.y - 22}, {corner.x + width + 26, corner.y + 38},
                      IM_COL32(0, 0, 0, 190), 4);
  list->AddText({corner.x, corner.y - 18}, IM_COL32(210, 210, 210, 255), text);
  for (int i = 0; i < 256; ++i) {
    const float left = corner.x + width * static_cast<float>(i) / 256;
    list->AddRectFilled({left, corner.y}, {left + width / 256 + 1, corner.y + height},
                        IM_COL32(colors[i][0], colors[i][1], colors[i][2], 255));
  }
  list->AddRect({corner.x - 1, corner.y - 1}, {corner.x + width + 2, corner.y + height + 1},
                IM_COL32(128, 128, 128, 255));
  float free_from = -1e9f;  // labels that would overlap the previous one are left out
  for (const LegendMark& mark : legend_marks(range)) {
    const float x = corner.x + width * std::clamp(mark.place, 0.f, 1.f);
    list->AddLine({x, corner.y + height}, {x, corner.y + height + 4}, IM_COL32(210, 210, 210, 255));
    const float half = 0.5f * ImGui::CalcTextSize(mark.text.c_str()).x;
    if (x - half < free_from) continue;
    list->AddText({x - half, corner.y + height + 5}, IM_COL32(210, 210, 210, 255),
                  mark.text.c_str());
    free_from = x + half + 6;
  }
}

}  // namespace kinome::viewer
