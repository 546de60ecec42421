#include "panels/image_texture.h"

#include <GL/gl.h>

#include "picture/tone.h"

namespace kinome::viewer {

ImageTexture::~ImageTexture() {
  if (name_ != 0) glDeleteTextures(1, &name_);
}

void ImageTexture::set(const Image& image) {
  const std::vector<uint8_t> rgba = ToneMapper(Tone()).map(image);
  if (name_ == 0) glGenTextures(1, &name_);
  width_ = image.width;
  height_ = image.height;
  glBindTexture(GL_TEXTURE_2D, name_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width_, height_, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               rgba.data());
}

ImTextureID ImageTexture::id() const {
  return reinterpret_cast<ImTextureID>(static_cast<intptr_t>(name_));
}

}  // namespace kinome::viewer
