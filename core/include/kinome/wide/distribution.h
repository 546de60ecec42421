#pragma once

// GridDistribution::sample for many numbers, to the last bit.

#include "kinome/distribution.h"
#include "kinome/wide/vectors.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Of one row of a distribution's tables, or of the marginal: its entries of `cdf` and of `guide`
/// begin at cdf_first and guide_first. See GridDistribution::find; u in [0, 1).
KINOME_WIDE Int find_cell(const float* cdf, Int cdf_first, const uint32_t* guide, Int guide_first,
                          uint32_t guide_size, Float& u) {
  const Int k = guide_first + to_int(u * static_cast<float>(guide_size));
  Int first = cdf_first + as_int(gather(guide, k));
  Int length = cdf_first + as_int(gather(guide + 1, k)) - first;
  for (Mask searched = length > 0; any(searched); searched = length > 0) {
    const Int half = shift_right<1>(length);
    const Mask above = searched & (gather(cdf, first + half) <= u);
    first = select(above, first + half + 1, first);
    length = select(above, length - half - 1, half);
  }
  const Float end = gather(cdf, first);
  const Float start = select(first > cdf_first, gather(cdf, max(first - 1, 0)));
  u = min((u - start) / (end - start), kOneMinusEpsilon);
  return first - cdf_first;
}

/// In [0, 1): padding may be anything, and places in tables are found by such numbers.
KINOME_WIDE Float unit_number(Float u) {
  return min(max(0.f, u), kOneMinusEpsilon);
}

/// As GridDistribution::Cell.
struct GridCell {
  Int column, row;
  Vec2 u;
};
/// GridDistribution::sample, of tables of less than 2^31 entries.
KINOME_WIDE GridCell sample_grid(const GridDistribution::Tables& tables, Vec2 u) {
  GridCell cell;
  cell.u = {unit_number(u.x), unit_number(u.y)};
  cell.row = find_cell(tables.row_cdf, 0, tables.row_guide, 0, tables.row_guide_size, cell.u.y);
  const auto columns = static_cast<int32_t>(tables.columns);
  const auto guide = static_cast<int32_t>(tables.column_guide_size) + 1;
  cell.column = find_cell(tables.column_cdf, cell.row * columns, tables.column_guide,
                          cell.row * guide, tables.column_guide_size, cell.u.x);
  return cell;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
