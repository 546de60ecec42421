#pragma once

#include <limits>

#include "surfaces.h"

namespace kinome::transport {

/// Of points that paths have come to: the last vertex at which the path did not go straight through
/// a surface (Lobe::kNull), so that emitter samples of that vertex find the same light.
struct Origins {
  Columns3 p;  ///< position of the vertex
  /// Density of the path from there to the point: per solid angle at the vertex, times the
  /// probability of going straight through all surfaces between. Infinite if no emitter sample of
  /// the vertex finds the light: for the camera and for delta lobes. kBeyondPasses behind
  /// kMaxPasses surfaces.
  float* pdf = nullptr;
  float* passes = nullptr;  ///< number of surfaces between
};

/// Surfaces that an emitter sample goes straight through, at most. Light behind more of them is
/// found by BSDF samples alone.
inline constexpr uint32_t kMaxPasses = 32;
/// Origins::pdf of directions in which emitter samples find no light because of kMaxPasses alone.
inline constexpr float kBeyondPasses = std::numeric_limits<float>::max();

/// Points of paths at which light is looked for.
struct Vertices {
  const Surfaces* surfaces;
  const uint32_t* owner;  ///< of each point, the sample of the block that its path belongs to
  Columns3 throughput;    ///< what radiance toward the viewer counts as; nullptr: all of it
  /// By owners: the share of the path in light of emitters that a delta lobe shows it, which others
  /// look for, too; and what that becomes once another lobe has sent the path on, when DirectLight
  /// puts it in the former's place. Surfaces that light passes straight don't matter. nullptr: all
  /// of it.
  float* shown_share = nullptr;
  const float* shown_share_later = nullptr;
  /// By owners: 1 while all samples of the path's BSDFs went straight through (Lobe::kNull), else
  /// 0; such paths don't see the environment, which is hidden. nullptr: it isn't hidden.
  float* straight = nullptr;
  /// Columns are nullptr if emitter samples stop at all surfaces.
  Origins origins = {};
  /// Samples that go straight through the surface (Lobe::kNull) are dropped: others follow them.
  bool drops_straight = false;
};

}  // namespace kinome::transport
