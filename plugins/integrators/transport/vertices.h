#pragma once

#include "surfaces.h"

namespace kinome::transport {

/// Points of paths at which light is looked for.
struct Vertices {
  const Surfaces* surfaces;
  const uint32_t* owner;  ///< of each point, the sample of the block that its path belongs to
  Columns3 throughput;    ///< what radiance toward the viewer counts as; nullptr: all of it
};

}  // namespace kinome::transport
