#include "window/picture_view.h"

#include <imgui.h>

#include <algorithm>

#include "picture/tone.h"

namespace kinome::viewer {
namespace {

constexpr float kMaxZoom = 256;

}  // namespace

void PictureView::set_tone(ToneFunction tone) {
  tone_ = std::move(tone);
  refresh();
}

void PictureView::upload(const Picture& picture) {
  const auto& image = picture.image;
  if (tone_) {
    tone_(picture, rgba_);
  } else {
    rgba_ = ToneMapper(Tone()).map(image);
  }
  rgba_.resize(4 * static_cast<size_t>(image.width) * image.height);
  texture_.set(image.width, image.height, rgba_);
  shown_generation_ = picture.generation;
}

/// Centres the image. Without a zoom, it fills the width or the height.
void PictureView::place(const Rect& crop) {
  const ImVec2 low = ImGui::GetCursorScreenPos(), space = ImGui::GetContentRegionAvail();
  area_.low = Vec2(low.x, low.y);
  area_.high = area_.low + Vec2(space.x, space.y);
  area_.crop = crop;
  const Vec2 size(std::max(1, crop.width()), std::max(1, crop.height()));
  const float fits = std::min(space.x / size.x, space.y / size.y);
  area_.scale = std::max(fits, 0.01f) * zoom_;
  const Vec2 middle = 0.5f * (area_.low + area_.high) + offset_;
  area_.corner = glm::floor(middle - 0.5f * area_.scale * size);
}

void PictureView::draw(const PicturePointer& picture) {
  if (!picture) {
    place(Rect{0, 0, 1, 1});
    return;
  }
  if (picture->generation != shown_generation_) upload(*picture);
  place(picture->crop);
  // Magnified pixels stay sharp, except those of previews.
  texture_.set_filter(picture->is_preview ? ImageTexture::Filter::kBilinear
                      : area_.scale < 1   ? ImageTexture::Filter::kReduce
                                          : ImageTexture::Filter::kNearest);
  const Vec2 end = area_.corner + area_.scale * Vec2(area_.crop.width(), area_.crop.height());
  ImDrawList* const list = ImGui::GetWindowDrawList();
  list->PushClipRect({area_.low.x, area_.low.y}, {area_.high.x, area_.high.y}, true);
  list->AddImage(texture_.id(), {area_.corner.x, area_.corner.y}, {end.x, end.y});
  list->PopClipRect();
}

void PictureView::zoom(float factor, const Vec2& window_position) {
  const float before = zoom_;
  zoom_ = std::clamp(zoom_ * factor, 1.f, kMaxZoom);
  if (zoom_ == 1) return reset_zoom();
  const Vec2 middle = 0.5f * (area_.low + area_.high);
  const Vec2 from_middle = window_position - middle - offset_;
  offset_ += from_middle * (1 - zoom_ / before);
}

}  // namespace kinome::viewer
