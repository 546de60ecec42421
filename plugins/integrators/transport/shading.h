#pragma once

#include "surfaces.h"

namespace kinome::transport {

BsdfAnswer make_answer(Arena& arena);

/// Asks each material once for all points on its surfaces.
void shade(const Surfaces& surfaces, const BsdfQuery& query, const BsdfAnswer& answer);

}  // namespace kinome::transport
