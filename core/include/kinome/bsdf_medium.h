#pragma once

#include <memory>

#include "kinome/bsdf.h"
#include "kinome/medium.h"

namespace kinome {

/// Optional interface of BSDFs that describe the inside of a body, too: derive them from this class
/// in addition to Bsdf. Shapes with such a BSDF, or with one that contains it, have its medium as
/// their interior.
class KINOME_EXPORT InteriorMedium {
 public:
  virtual ~InteriorMedium();
  /// Medium behind the surface, opposite to the geometric normal. Never nullptr, and always the
  /// same object.
  virtual std::shared_ptr<const Medium> interior() const = 0;
};

/// Returns the medium of a BSDF or of those nested in it; nullptr if none has one. Throws Error
/// without a location if several have different media.
KINOME_EXPORT std::shared_ptr<const Medium> interior_of(const Bsdf& bsdf);

}  // namespace kinome
