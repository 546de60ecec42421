#pragma once

#include <imgui.h>

#include "kinome/image.h"

namespace kinome::viewer {

/// An OpenGL texture for ImGui::Image. For the thread of the OpenGL context only.
class ImageTexture {
 public:
  ImageTexture() = default;
  ~ImageTexture();
  ImageTexture(const ImageTexture&) = delete;
  ImageTexture& operator=(const ImageTexture&) = delete;

  /// Uploads the channels R, G and B of an image as sRGB.
  void set(const Image& image);
  ImTextureID id() const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace kinome::viewer
