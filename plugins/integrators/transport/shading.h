#pragma once

#include "surfaces.h"

namespace kinome::transport {

BsdfAnswer make_answer(Arena& arena);

/// Calls each BSDF once for all points on its surfaces. BSDFs that don't scatter have zero values;
/// they are called only for samples.
void shade(const Surfaces& surfaces, const BsdfQuery& query, const BsdfAnswer& answer);
/// The same for points seen from `wi` instead of the rays' origins. `wi`: unit vectors in the
/// shading frames of the points that reflect.
void shade(const Surfaces& surfaces, const Columns3& wi, const BsdfQuery& query,
           const BsdfAnswer& answer);

}  // namespace kinome::transport
