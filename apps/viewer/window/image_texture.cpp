#include "window/image_texture.h"

#include <GL/gl.h>
#include <GLFW/glfw3.h>

#include <utility>

#include "picture/tone.h"

namespace kinome::viewer {

ImageTexture::~ImageTexture() {
  if (name_ != 0) glDeleteTextures(1, &name_);
}

void ImageTexture::set(const Image& image) {
  set(image.width, image.height, ToneMapper(Tone()).map(image));
}

void ImageTexture::set(int width, int height, const std::vector<uint8_t>& rgba) {
  if (name_ == 0) glGenTextures(1, &name_);
  width_ = width;
  height_ = height;
  glBindTexture(GL_TEXTURE_2D, name_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width_, height_, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               rgba.data());
  has_mipmaps_ = false;
}

void ImageTexture::set_filter(Filter filter) {
  using GenerateMipmap = void (*)(GLenum target);
  static const auto generate_mipmap =
      reinterpret_cast<GenerateMipmap>(glfwGetProcAddress("glGenerateMipmap"));
  glBindTexture(GL_TEXTURE_2D, name_);
  const bool uses_mipmaps = filter == Filter::kReduce && generate_mipmap;
  if (uses_mipmaps && !std::exchange(has_mipmaps_, true)) generate_mipmap(GL_TEXTURE_2D);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                  uses_mipmaps ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER,
                  filter == Filter::kNearest ? GL_NEAREST : GL_LINEAR);
}

}  // namespace kinome::viewer
