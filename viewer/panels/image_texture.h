#pragma once

#include <imgui.h>

#include "kinome/image.h"

namespace kinome::viewer {

/// A picture beside the one that is rendered, for ImGui::Image. Of the thread that has the OpenGL
/// context.
class ImageTexture {
 public:
  ImageTexture() = default;
  ~ImageTexture();
  ImageTexture(const ImageTexture&) = delete;
  ImageTexture& operator=(const ImageTexture&) = delete;

  /// By sRGB, of channels R, G and B.
  void set(const Image& image);
  ImTextureID id() const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace kinome::viewer
