// Multi-jittered sampling (Chiu et al. 1994; Kensler 2013). sample_count = m n samples are jittered
// in m x n strata of the square, such that each coordinate alone has m n strata, too. Further
// samples form sets of the same kind.
//
//   <sampler type="multijitter"><integer name="sample_count" value="64"/></sampler>

#include "kinome/plugin.h"
#include "strata.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    KINOME_SAMPLER_PARAMETERS,
    kJitter,
};

/// Returns a grid of at least `count` cells that is nearly square.
Grid grid_for(uint32_t count) {
  uint32_t rows = 1;
  while ((rows + 1) * (rows + 1) <= count) ++rows;
  return {(count + rows - 1) / rows, rows};
}

/// m x n strata of the square, and m n strata of each coordinate.
struct Jitters : GridSet {
  using GridSet::GridSet;
  static Jitters of_size(uint32_t count, bool jitters) { return {grid_for(count), jitters}; }

  template <class U>
  KINOME_WIDE Pair<U> square(U within, const PixelKey<U>& key) const {
    const PermutedCell<U> cell = order.cell(within, key);
    const Pair<U> offset = jitter.two(within, key);
    // The samples of a column use different fine strata of the column; the same holds for rows.
    // Their order is independent of the order of columns and rows, and begins at a random stratum
    // in each column. With one order for all columns, as in Kensler's method, their errors add up,
    // and the variance decreases like count^-1.5 instead of count^-2.
    return {in_stratum(columns.part(cell.column, cell.row, column_bits(key)), offset.x, size),
            in_stratum(rows.part(cell.row, cell.column, row_bits(key)), offset.y, size)};
  }
};

using MultiJitter = StratifyingSampler<Jitters>;

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::MultiJitter, kinome::Category::kSampler, "multijitter",
              "Multi-jittered samples: stratified in the square and in each coordinate.",
              kinome::kTable);
