#pragma once

#include "surfaces.h"

namespace kinome::transport {

BsdfAnswer make_answer(Arena& arena);

/// Asks each material once for all points on its surfaces; those that don't scatter, whose values
/// are zero, for samples alone.
void shade(const Surfaces& surfaces, const BsdfQuery& query, const BsdfAnswer& answer);
/// The same, as seen from `wi` in place of where the rays came from: of points that reflect, unit,
/// in their shading frames.
void shade(const Surfaces& surfaces, const Columns3& wi, const BsdfQuery& query,
           const BsdfAnswer& answer);

}  // namespace kinome::transport
