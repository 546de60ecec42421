#pragma once

// GridDistribution::sample() for vectors of random numbers, with identical bits.

#include "kinome/distribution.h"
#include "kinome/wide/vectors.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Range of CDF entries that still contains the result of the search: the first entry above u, or
/// the end of the range.
struct CellRange {
  Int first, length;

  /// Halves the range by one step of the binary search for u, in lanes where it isn't empty.
  KINOME_WIDE void halve(const float* cdf, Float u) {
    const Int half = shift_right<1>(length);
    const Mask searched = length > 0;
    const Mask above = searched & (gather(cdf, first + half) <= u);
    first = select(above, first + half + 1, first);
    length = select(above, length - half - 1, half);
  }
};
/// Returns the range of entry `k` of `guide`, for a row whose CDF begins at cdf_first. See
/// GridDistribution::find().
KINOME_WIDE CellRange cells_at(Int cdf_first, const uint32_t* guide, Int k) {
  const Int first = cdf_first + as_int(gather(guide, k));
  return {first, cdf_first + as_int(gather(guide + 1, k)) - first};
}
/// Returns the index in the row of entry `place` of the table, and remaps u to the position in that
/// cell.
KINOME_WIDE Int enter_cell(const float* cdf, Int cdf_first, Int place, Float& u) {
  const Float end = gather(cdf, place);
  const Float start = select(place > cdf_first, gather(cdf, max(place - 1, 0)));
  u = min((u - start) / (end - start), kOneMinusEpsilon);
  return place - cdf_first;
}

/// Searches one row of a distribution's tables, or the marginal; its entries begin at cdf_first and
/// guide_first. See GridDistribution::find(); u is in [0, 1).
KINOME_WIDE Int find_cell(const float* cdf, Int cdf_first, const uint32_t* guide, Int guide_first,
                          uint32_t guide_size, Float& u) {
  CellRange cells =
      cells_at(cdf_first, guide, guide_first + to_int(u * static_cast<float>(guide_size)));
  while (any(cells.length > 0)) cells.halve(cdf, u);
  return enter_cell(cdf, cdf_first, cells.first, u);
}

/// Clamps u to [0, 1), so that padding, which may hold anything, gives valid table indices.
KINOME_WIDE Float unit_number(Float u) {
  return min(max(0.f, u), kOneMinusEpsilon);
}

/// GridDistribution::Cell for wide numbers.
struct GridCell {
  Int column, row;
  Vec2 u;
};
/// GridDistribution::sample() for tables of less than 2^31 entries.
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
