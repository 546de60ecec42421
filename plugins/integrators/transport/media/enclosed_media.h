#pragma once

#include "kinome/scene.h"

namespace kinome::transport {

/// Returns true if light can neither enter nor leave a medium along a straight line, and no emitter
/// is inside of it, provided that the surfaces of its shapes are closed. Shadow rays from the
/// inside can't reach an emitter then. Light finds the way through the boundary only by scattering,
/// as through glass.
bool is_enclosed(const Medium& medium, const Scene& scene, const Sensor& sensor);

/// Returns true if no shape has the medium as its interior, and it has no box of its own.
bool is_endless(const Medium& medium, const Scene& scene);

}  // namespace kinome::transport
