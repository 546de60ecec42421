#include "window/image_texture.h"

#include <GL/gl.h>

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
}

void ImageTexture::set_sharp(bool is_sharp) {
  glBindTexture(GL_TEXTURE_2D, name_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, is_sharp ? GL_NEAREST : GL_LINEAR);
}

}  // namespace kinome::viewer
