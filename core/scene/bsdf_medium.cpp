#include "kinome/bsdf_medium.h"

#include "kinome/error.h"

namespace kinome {

InteriorMedium::~InteriorMedium() = default;

std::shared_ptr<const Medium> interior_of(const Bsdf& bsdf) {
  if (const auto* const source = dynamic_cast<const InteriorMedium*>(&bsdf)) {
    return source->interior();
  }
  std::shared_ptr<const Medium> found;
  for (const auto& part : bsdf.nested()) {
    const auto* const nested = dynamic_cast<const Bsdf*>(part.get());
    const auto medium = nested ? interior_of(*nested) : nullptr;
    if (!medium) continue;
    if (found && found != medium) {
      throw Error("the BSDFs nested in '" + bsdf.plugin() + "' have different interior media");
    }
    found = medium;
  }
  return found;
}

}  // namespace kinome
