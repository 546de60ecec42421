#include "clustered/product/paths/mirrored_direction.h"

#include "clustered/product/tiles/spread.h"
#include "kinome/shape.h"

namespace kinome {

std::optional<MirroredDirection> mirrored_direction(const SurfaceInteraction& si, uint32_t primary,
                                                    uint64_t seed) {
  const Bsdf& bsdf = si.shape->bsdf();
  if (!any(bsdf.lobes() & Lobe::kDelta)) return std::nullopt;
  const Vec2 u(random_float(seed, 2 * primary), random_float(seed, 2 * primary + 1));
  const auto sample = bsdf.sample(si, Lobe::kDelta, random_float(hash_words(seed, primary), 0), u);
  if (!sample) return std::nullopt;
  return MirroredDirection{si.frame.to_world(sample->wo), sample->weight};
}

}  // namespace kinome
