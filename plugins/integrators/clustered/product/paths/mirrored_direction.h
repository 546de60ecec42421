#pragma once

#include <cstdint>
#include <optional>

#include "kinome/color.h"
#include "kinome/interaction.h"

namespace kinome {

/// A direction from which delta lobes reflect or transmit light to the viewer.
struct MirroredDirection {
  Vec3 d;
  Rgb weight;  ///< factor of the radiance from d
};
/// Samples such a direction at a primary; random numbers depend on `seed` and the primary. Returns
/// nullopt if the BSDF has no delta lobes or sampling fails.
std::optional<MirroredDirection> mirrored_direction(const SurfaceInteraction& si, uint32_t primary,
                                                    uint64_t seed);

}  // namespace kinome
