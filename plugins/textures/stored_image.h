#pragma once

#include "image_reader.h"
#include "kinome/error.h"
#include "kinome/properties.h"

namespace kinome {

/// Pixels of a plugin with the parameters `filename` and `data`: those that a program gives, or the
/// file's, in any format. The core reads EXR and PFM, recognised by their first bytes;
/// ReadImageFunction reads all others. All values are finite: NaN becomes 0, and infinity 65504 (the
/// largest value of float16, whose overflow it usually is), or the image's largest if that is more.
/// Warns of these, and of negative values if they matter. Throws an Error at the file, or at the
/// parameter `filename` if a library that is needed can't be opened. Thread-safe.
struct LoadedImage {
  explicit LoadedImage(const Properties& props);

  StoredImage image;
  Location source;  ///< the file, or the parameter `data`; for messages
};

}  // namespace kinome
