#pragma once

#include "kinome/scene.h"

namespace kinome::transport {

/// True if no light can enter or leave a medium along a straight line, and no emitter is inside of
/// it, provided that the surfaces of its shapes are closed. Shadow rays from the inside then can't
/// reach an emitter. Light passes the boundary only by scattering or refraction, as through glass.
bool is_enclosed(const Medium& medium, const Scene& scene, const Sensor& sensor);

/// True if no shape has the medium as its interior, and the medium has no box.
bool is_unbounded(const Medium& medium, const Scene& scene);

}  // namespace kinome::transport
