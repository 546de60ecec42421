#pragma once

#include "kinome/scene.h"

namespace kinome::transport {

/// Boundary of a medium, determined by rays.
struct Boundary {
  enum class Kind { kClosed, kOpen, kInverted };
  Kind kind = Kind::kClosed;
  const Shape* shape = nullptr;  ///< a shape of an open or inside-out boundary, else nullptr
};

/// Examines the boundary of a medium that is the interior of shapes, by some rays through them. All
/// rays enter and leave the medium equally often if the boundary is closed. Media that are only on
/// the outside of shapes count as closed. Small holes are not found.
Boundary boundary_of(const Medium& medium, const Scene& scene);

}  // namespace kinome::transport
