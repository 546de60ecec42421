#include "window/picture_view.h"

#include <GL/gl.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "picture/tone.h"

namespace kinome::viewer {
namespace {

constexpr float kMaxZoom = 256;

void to_srgb(const Picture& picture, std::vector<uint8_t>& rgba) {
  static const ToneMapper plain{Tone()};
  rgba = plain.map(picture.image);
}

}  // namespace

PictureView::PictureView() : tone_(to_srgb) {
  glGenTextures(1, &texture_);
}
PictureView::~PictureView() {
  glDeleteTextures(1, &texture_);
}

void PictureView::set_tone(ToneFunction tone) {
  tone_ = tone ? std::move(tone) : to_srgb;
  refresh();
}

void PictureView::upload(const Picture& picture) {
  const auto& image = picture.image;
  tone_(picture, rgba_);
  rgba_.resize(4 * static_cast<size_t>(image.width) * image.height);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               rgba_.data());
  shown_generation_ = picture.generation;
}

/// Centres the image, scaled by an integer if it is smaller than the window.
void PictureView::place(const Rect& crop) {
  const ImVec2 low = ImGui::GetCursorScreenPos(), space = ImGui::GetContentRegionAvail();
  area_.low = Vec2(low.x, low.y);
  area_.high = area_.low + Vec2(space.x, space.y);
  area_.crop = crop;
  const Vec2 size(std::max(1, crop.width()), std::max(1, crop.height()));
  const float fits = std::min(space.x / size.x, space.y / size.y);
  area_.scale = (fits >= 1 ? std::floor(fits) : std::max(fits, 0.01f)) * zoom_;
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
  const bool is_sharp = area_.scale >= 1 && !picture->is_preview;
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, is_sharp ? GL_NEAREST : GL_LINEAR);
  const Vec2 end = area_.corner + area_.scale * Vec2(area_.crop.width(), area_.crop.height());
  ImDrawList* const list = ImGui::GetWindowDrawList();
  list->PushClipRect({area_.low.x, area_.low.y}, {area_.high.x, area_.high.y}, true);
  list->AddImage(reinterpret_cast<ImTextureID>(static_cast<intptr_t>(texture_)),
                 {area_.corner.x, area_.corner.y}, {end.x, end.y});
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
