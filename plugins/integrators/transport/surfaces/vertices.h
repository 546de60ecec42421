#pragma once

#include <limits>

#include "transport/surfaces/surfaces.h"

namespace kinome::transport {

/// For each point of a path, the last vertex before it where the path did not go straight through a
/// surface (Lobe::kNull). Emitter samples of that vertex find the same light.
struct Origins {
  Columns3 p;  ///< position of the vertex
  /// Density of the path from there to the point: per solid angle at the vertex, times the
  /// probability of going straight through all surfaces between. Infinite if emitter samples of the
  /// vertex can't find the light: for the camera and for delta lobes. At least kPdfBeyondPasses
  /// behind more than kMaxPasses surfaces.
  float* pdf = nullptr;
  float* passes = nullptr;  ///< number of surfaces between
};

/// Maximum number of surfaces that an emitter sample goes straight through. Only BSDF samples find
/// light behind more of them.
inline constexpr uint32_t kMaxPasses = 32;
/// Origins::pdf of directions in which emitter samples find no light only because of kMaxPasses.
inline constexpr float kPdfBeyondPasses = std::numeric_limits<float>::max();

/// Points of paths at which direct light is computed.
struct Vertices {
  const Surfaces* surfaces;
  const uint32_t* owner;  ///< sample of the block that each point's path belongs to
  Columns3 throughput;    ///< factor of the radiance toward the viewer; nullptr: 1
  /// For each owner: the weight of the path in emitters' light that a delta lobe shows, if other
  /// techniques find this light, too. DirectLight replaces it by shown_share_later once another
  /// lobe has scattered the path. Surfaces that light passes straight don't matter. nullptr: 1.
  float* shown_share = nullptr;
  const float* shown_share_later = nullptr;
  /// For each owner: 1 while all BSDF samples of the path went straight through (Lobe::kNull), else
  /// 0. While it is 1, the path doesn't see the hidden environment. nullptr: it isn't hidden.
  float* straight = nullptr;
  /// Columns are nullptr if emitter samples stop at all surfaces.
  Origins origins = {};
  /// True if samples that go straight through the surface (Lobe::kNull) are dropped, because other
  /// techniques follow them.
  bool drops_straight = false;
};

}  // namespace kinome::transport
