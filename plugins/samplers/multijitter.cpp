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
struct Jitters {
  Jitters(const Grid& of, bool jitters)
      : grid(of), columns(of.columns.number()), rows(of.rows.number()), jitter{jitters} {}

  uint32_t count() const { return grid.count(); }

  template <class U>
  KINOME_WIDE Real<U> line(U within, const Key<U>& key) const {
    return in_stratum(grid.number(grid.permute(grid.cell(within), key)), jitter.one(within, key),
                      count());
  }
  template <class U>
  KINOME_WIDE Pair<U> square(U within, const Key<U>& key) const {
    const Cell<U> cell = grid.permute(grid.cell(within), key);
    // Each sample of a column takes another one of the column's finer strata, and so in the rows. The
    // order of these is independent of where columns and rows are, and begins at a random stratum in each
    // column: with one order for all, as Kensler has it, errors of the columns add up, and the variance
    // falls like count^-1.5 instead of count^-2.
    const U column = columns.permute(cell.column, key.low);
    const U row = rows.permute(cell.row, key.high);
    const U fine_x = grid.rows.rotate<0x2545f491u>(cell.row, cell.column, key.high);
    const U fine_y = grid.columns.rotate<0x4f6cdd1du>(cell.column, cell.row, key.low);
    const Pair<U> place = jitter.two(within, key);
    return {in_stratum(column * U(grid.rows.number()) + fine_x, place.x, count()),
            in_stratum(row * U(grid.columns.number()) + fine_y, place.y, count())};
  }

  Grid grid;
  PermutationTable columns, rows;
  Jitter jitter;
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
