#pragma once

#include <cstdint>
#include <vector>

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

  /// Uploads pixels of 8-bit sRGB with R, G, B and A, rows from top to bottom.
  void set(int width, int height, const std::vector<uint8_t>& rgba);
  /// Uploads the channels R, G and B of an image as sRGB.
  void set(const Image& image);
  enum class Filter {
    kBilinear,
    kNearest,  ///< keeps magnified pixels sharp
    kReduce    ///< averages pixels (mipmaps), for images that are displayed smaller
  };
  /// Selects the filter for the display. The default is kBilinear.
  void set_filter(Filter filter);
  ImTextureID id() const { return reinterpret_cast<ImTextureID>(static_cast<intptr_t>(name_)); }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
  bool has_mipmaps_ = false;
};

}  // namespace kinome::viewer
