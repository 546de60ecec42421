#pragma once

#include "transport/surfaces/surfaces.h"

namespace kinome::transport {

BsdfAnswer make_answer(Arena& arena);

/// Calls each BSDF once for all points on its surfaces. BSDFs that don't scatter have zero values;
/// they are called only for samples.
void shade(const Surfaces& surfaces, const BsdfQuery& query, const BsdfAnswer& answer);
/// The same for points seen from `wi` instead of the rays' origins. `wi` contains unit vectors in
/// the shading frames of the reflecting points.
void shade(const Surfaces& surfaces, const Columns3& wi, const BsdfQuery& query,
           const BsdfAnswer& answer);

}  // namespace kinome::transport
