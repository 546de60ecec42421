#pragma once

#include "surfaces.h"

namespace kinome::transport {

/// Points of paths at which light is looked for.
struct Vertices {
  const Surfaces* surfaces;
  const uint32_t* owner;  ///< of each point, the sample of the block that its path belongs to
  Columns3 throughput;    ///< what radiance toward the viewer counts as; nullptr: all of it
  /// By owners: the share of the path in light of emitters that a delta lobe shows it, which others
  /// look for, too; and what that becomes once another lobe has sent the path on, when DirectLight
  /// puts it in the former's place. nullptr: all of it.
  float* shown_share = nullptr;
  const float* shown_share_later = nullptr;
  /// By owners: 1 while all samples of the path's BSDFs went straight through (Lobe::kNull), else
  /// 0; such paths don't see the environment, which is hidden. nullptr: it isn't hidden.
  float* straight = nullptr;
};

}  // namespace kinome::transport
