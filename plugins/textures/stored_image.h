#pragma once

#include "image_reader.h"
#include "kinome/error.h"
#include "kinome/properties.h"

namespace kinome {

/// Image of a plugin with the parameters `filename` and `data`: from a program, or from a file in
/// any supported format. The core reads EXR and PFM, recognised by their first bytes; a
/// ReadImageFunction reads all others.
///
/// All values are finite: NaN becomes 0. Infinity becomes 65504 (the largest float16, because it is
/// usually an overflow of that type), or the image's largest value if that is larger. Warns about
/// these, and about negative values if they matter. Throws Error at the file, or at the parameter
/// `filename` if a required library can't be opened. Thread-safe.
struct LoadedImage {
  explicit LoadedImage(const Properties& props);

  StoredImage image;
  Location source;  ///< the file, or the parameter `data`; for messages
};

}  // namespace kinome
