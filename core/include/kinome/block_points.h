#pragma once

#include "kinome/blocks.h"
#include "kinome/export.h"
#include "kinome/interaction.h"

namespace kinome {

/// Point i of a block by itself; its t isn't known.
KINOME_EXPORT SurfaceInteraction interaction_of(const SurfaceBlock& points, size_t i);

}  // namespace kinome
