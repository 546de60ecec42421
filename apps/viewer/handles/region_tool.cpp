#include "handles/region_tool.h"

#include <imgui.h>

namespace kinome::viewer {
namespace {

constexpr ImU32 kRegionColor = IM_COL32(120, 220, 255, 255), kShadeColor = IM_COL32(0, 0, 0, 110);
/// Minimum side of a region [pixels of the film].
constexpr int kMinRegionSide = 2;

}  // namespace

Rect RegionTool::dragged() const {
  const Vec2 low = glm::floor(glm::min(*start_, end_)), high = glm::ceil(glm::max(*start_, end_));
  return {static_cast<int>(low.x), static_cast<int>(low.y), static_cast<int>(high.x),
          static_cast<int>(high.y)};
}

bool RegionTool::press(const PictureClick& click) {
  if (click.button != 0 || !click.ctrl || !click.shift) return false;
  start_ = end_ = click.film;
  return true;
}

void RegionTool::release(Frame& frame) {
  const Rect region = dragged();
  start_.reset();
  const bool is_large = region.width() >= kMinRegionSide && region.height() >= kMinRegionSide;
  frame.session.set_region(is_large ? std::optional(region) : std::nullopt);
}

void RegionTool::draw(const Frame& frame) const {
  const std::optional<Rect> region = start_ ? std::optional(dragged()) : frame.status.region;
  if (!region) return;
  const PictureArea& area = frame.view.area();
  const Vec2 low = area.to_window(Vec2(region->x0, region->y0));
  const Vec2 high = area.to_window(Vec2(region->x1, region->y1));
  ImDrawList* const list = ImGui::GetWindowDrawList();
  list->PushClipRect({area.low.x, area.low.y}, {area.high.x, area.high.y}, true);
  if (start_) {
    list->AddRectFilled({area.low.x, area.low.y}, {area.high.x, low.y}, kShadeColor);
    list->AddRectFilled({area.low.x, high.y}, {area.high.x, area.high.y}, kShadeColor);
    list->AddRectFilled({area.low.x, low.y}, {low.x, high.y}, kShadeColor);
    list->AddRectFilled({high.x, low.y}, {area.high.x, high.y}, kShadeColor);
  }
  list->AddRect({low.x - 1, low.y - 1}, {high.x + 1, high.y + 1}, IM_COL32(0, 0, 0, 150), 0, 0, 3);
  list->AddRect({low.x - 1, low.y - 1}, {high.x + 1, high.y + 1}, kRegionColor, 0, 0, 1.5f);
  list->PopClipRect();
}

}  // namespace kinome::viewer
