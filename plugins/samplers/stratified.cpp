// Stratified sampling: one jittered sample in each of the sample_count = n² strata of a pixel. The
// strata have a random order for each dimension and pixel, so that dimensions are independent.
// After n² samples, another stratified set follows. Without `jitter`, each sample is at the centre
// of its stratum.
//
//   <sampler type="stratified"><integer name="sample_count" value="64"/></sampler>

#include "kinome/plugin.h"
#include "strata.h"

namespace kinome {
namespace {

const Parameter kTable[] = {KINOME_SAMPLER_PARAMETERS, kJitter};

uint32_t side_for(uint32_t count) {
  uint32_t side = 1;
  while (side * side < count) ++side;
  return side;
}

/// n x n strata.
struct Squares : GridSet {
  Squares(uint32_t side, bool jitters)
      : GridSet(Grid(side, side), jitters), width(1 / static_cast<float>(side)) {}
  static Squares of_size(uint32_t count, bool jitters) { return {side_for(count), jitters}; }

  template <class U>
  KINOME_WIDE Pair<U> square(U within, const PixelKey<U>& key) const {
    const PermutedCell<U> cell = order.cell(within, key);
    const Pair<U> offset = jitter.two(within, key);
    return {in_stratum(columns.line(cell.column, column_bits(key)), offset.x, width),
            in_stratum(rows.line(cell.row, row_bits(key)), offset.y, width)};
  }

  float width;  ///< side of a stratum in the square
};

using Stratified = StratifyingSampler<Squares>;

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Stratified, kinome::Category::kSampler, "stratified",
              "Jittered samples in a square number of strata.", kinome::kTable);
