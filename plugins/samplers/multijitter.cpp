// Multi-jittered sampling (Chiu et al. 1994), its orders being permutations that need no table
// (Kensler 2013): sample_count = m n samples, jittered in m x n strata of the square such that each
// coordinate alone is stratified m n times. After these, others follow that are as evenly spread.
//
//   <sampler type="multijitter"><integer name="sample_count" value="64"/></sampler>

#include <memory>

#include "kinome/plugin.h"
#include "strata.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    KINOME_SAMPLER_PARAMETERS,
    kJitter,
};

/// Nearly as many columns as rows.
Grid grid_for(uint32_t count) {
  uint32_t rows = 1;
  while ((rows + 1) * (rows + 1) <= count) ++rows;
  return {(count + rows - 1) / rows, rows};
}

/// m x n strata of the square, and m n strata of each coordinate.
struct Jitters : GridSet {
  using GridSet::GridSet;

  template <class U>
  KINOME_WIDE Pair<U> square(U within, const PixelKey<U>& key) const {
    const PermutedCell<U> cell = order.cell(within, key);
    const Pair<U> place = jitter.two(within, key);
    // Each sample of a column takes another one of the column's finer strata, and so in the rows.
    // The order of these is independent of where columns and rows are, and begins at a random
    // stratum in each column: with one order for all, as Kensler has it, errors of the columns add
    // up, and the variance falls like count^-1.5 instead of count^-2.
    return {in_stratum(columns.place(cell.column, cell.row, column_bits(key)), place.x, size),
            in_stratum(rows.place(cell.row, cell.column, row_bits(key)), place.y, size)};
  }
};

class MultiJitter : public StratifyingSampler<Jitters> {
 public:
  explicit MultiJitter(const Properties& props)
      : MultiJitter(read_sample_count(props), static_cast<uint64_t>(props.integer("seed")),
                    props.boolean("jitter")) {
    warn_if_rounded(props, read_sample_count(props), sample_count_);
  }
  MultiJitter(uint32_t count, uint64_t seed, bool jitters)
      : StratifyingSampler(Jitters(grid_for(count), jitters), seed) {}

  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<MultiJitter>(count, seed_, method().jitter.is_random);
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::MultiJitter, kinome::Category::kSampler, "multijitter",
              "Multi-jittered samples: stratified in the square and in each coordinate.",
              kinome::kTable);
