#pragma once

#include "picture/light_sliders.h"
#include "session/picture.h"

namespace kinome::viewer {

/// The displayed image, whose light the user has changed by LightSliders. For the window's thread
/// only.
class RelitPicture {
 public:
  /// Returns the image with the sliders' light: the same image if it has no light groups, or if
  /// nothing is changed. Also lists its groups in the sliders. Returns nullptr for nullptr.
  PicturePointer shown(const PicturePointer& picture, LightSliders& sliders);

 private:
  PicturePointer original_, relit_;
  std::vector<LightSliders::Group> factors_;  ///< of relit_
  uint64_t num_relit_ = 0;
};

}  // namespace kinome::viewer
