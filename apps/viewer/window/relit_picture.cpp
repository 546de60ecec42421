#include "window/relit_picture.h"

#include <utility>

namespace kinome::viewer {
namespace {

/// Numbers of relit images, which must differ from those of other images.
constexpr uint64_t kFirstRelitGeneration = uint64_t{1} << 61;

}  // namespace

PicturePointer RelitPicture::shown(const PicturePointer& picture, LightSliders& sliders) {
  if (!picture) return picture;
  sliders.follow(picture->image);
  if (!sliders.change(picture->image)) {
    original_ = relit_ = nullptr;
    return picture;
  }
  if (original_ == picture && factors_ == sliders.groups()) return relit_;
  auto relit = std::make_shared<Picture>(*picture);
  relit->image = sliders.relit(picture->image);
  relit->generation = kFirstRelitGeneration + num_relit_++;
  original_ = picture;
  factors_ = sliders.groups();
  relit_ = std::move(relit);
  return relit_;
}

}  // namespace kinome::viewer
