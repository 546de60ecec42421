#include "handles/selection_outline.h"

#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "window/viewer_window.h"

namespace kinome::viewer {
namespace {

constexpr ImU32 kOutlineColor = IM_COL32(255, 165, 50, 255);
/// Edge around the line, so that it is visible on any background.
constexpr ImU32 kOutlineEdgeColor = IM_COL32(0, 0, 0, 150);
constexpr float kOutlineWidth = 2, kOutlineEdgeWidth = 4;
/// Number of cells along the width of a preview. They are traced by the window's thread.
constexpr float kPreviewCells = 160;
/// Maximum number of cells along the longer side of an image, and the minimum size of a cell.
constexpr float kMaxCells = 1024, kMinCell = 0.25f;

}  // namespace

bool SelectionOutline::Key::operator==(const Key& other) const {
  return selection == other.selection && edition == other.edition && is_same(crop, other.crop) &&
         cell == other.cell;
}

/// Traces the outline again if the image shows another scene, camera or selection: at once for a
/// preview, with large cells, and otherwise in another thread. That outline replaces the preview's.
void SelectionOutline::update(Frame& frame) {
  using namespace std::chrono_literals;
  if (tracing_.valid() && tracing_.wait_for(0s) == std::future_status::ready) {
    auto traced = tracing_.get();
    if (tracing_key_ == key_) {
      if (!traced) key_ = {};  // the scene was changed in the meantime: try again
      if (traced) outline_ = std::move(traced);
    }
  }
  const PicturePointer& picture = frame.picture;
  if (!picture || !picture->sensor || !frame.selection || frame.selection->shape.empty()) {
    key_ = {};
    return outline_.reset();
  }
  const Rect& crop = picture->crop;
  const auto side = static_cast<float>(std::max(crop.width(), crop.height()));
  // A cell is about a pixel of the window. Powers of two need few new outlines during a zoom.
  const float fine = std::exp2(std::floor(-std::log2(frame.view.area().scale)));
  Key key{frame.selection, picture->edition, crop,
          std::max(std::clamp(fine, kMinCell, 1.f), side / kMaxCells)};
  if (picture->is_preview) {
    if (picture->generation == generation_ && key_.selection == frame.selection) return;
    key.cell = std::max(1.f, side / kPreviewCells);
    outline_ = frame.session.outline(*picture, key.selection->shape, key.cell, false);
    generation_ = picture->generation;
    key_ = key;
    return;
  }
  if (key == key_ || tracing_.valid()) return;
  if (key_.edition != key.edition || key_.selection != key.selection) outline_.reset();
  key_ = tracing_key_ = key;
  tracing_ = std::async(std::launch::async, [&session = frame.session, picture, key] {
    auto traced = session.outline(*picture, key.selection->shape, key.cell, true);
    ViewerWindow::wake();
    return traced;
  });
}

void SelectionOutline::draw(Frame& frame) {
  update(frame);
  if (!outline_) return;
  const PictureArea& area = frame.view.area();
  ImDrawList* const list = ImGui::GetWindowDrawList();
  list->PushClipRect({area.low.x, area.low.y}, {area.high.x, area.high.y}, true);
  for (const auto& [color, width] : {std::pair(kOutlineEdgeColor, kOutlineEdgeWidth),
                                     std::pair(kOutlineColor, kOutlineWidth)}) {
    for (const Outline::Line& line : outline_->lines) {
      const Vec2 a = area.to_window(outline_->points[line.from]);
      const Vec2 b = area.to_window(outline_->points[line.to]);
      list->AddLine({a.x, a.y}, {b.x, b.y}, color, width);
    }
  }
  list->PopClipRect();
}

}  // namespace kinome::viewer
