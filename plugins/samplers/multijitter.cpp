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

/// The square's division into columns and rows, nearly as many of each.
struct Grid {
  uint32_t columns, rows;
  explicit Grid(uint32_t count) : columns(0), rows(1) {
    while ((rows + 1) * (rows + 1) <= count) ++rows;
    columns = (count + rows - 1) / rows;
  }
};

class MultiJitter : public Sampler {
 public:
  explicit MultiJitter(const Properties& props)
      : MultiJitter(read_sample_count(props), static_cast<uint64_t>(props.integer("seed")),
                    props.boolean("jitter")) {
    warn_if_rounded(props, read_sample_count(props), sample_count_);
  }
  MultiJitter(uint32_t count, uint64_t seed, bool jitters) : grid_(count), jitters_(jitters) {
    sample_count_ = grid_.columns * grid_.rows;
    seed_ = seed;
  }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    const StratumPlace place = find(key, dimension ^ kOneDimension);
    return in_stratum(place.stratum, place.jitter.x, sample_count_);
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    const StratumPlace place = find(key, dimension ^ kTwoDimensions);
    const uint32_t column = place.stratum % grid_.columns, row = place.stratum / grid_.columns;
    const uint64_t orders = scatter(place.hash ^ 0x6d6a6974u);
    // Of the finer strata each sample of a column takes another one, and so in the rows. The order is
    // each column's own: with one for all, as Kensler has it, errors of the columns add up, and the
    // variance falls like count^-1.5 instead of count^-2.
    const uint32_t x =
        column * grid_.rows + permute(row, grid_.rows, scatter(orders + 2 * column));
    const uint32_t y =
        row * grid_.columns + permute(column, grid_.columns, scatter(orders + 2 * row + 1));
    return {in_stratum(x, place.jitter.x, sample_count_),
            in_stratum(y, place.jitter.y, sample_count_)};
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<MultiJitter>(count, seed_, jitters_);
  }

 private:
  StratumPlace find(const SampleKey& key, uint32_t salt) const {
    return stratum_of(key, sample_count_, salt, jitters_);
  }

  Grid grid_;
  bool jitters_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::MultiJitter, kinome::Category::kSampler, "multijitter",
              "Multi-jittered samples: stratified in the square and in each coordinate.",
              kinome::kTable);
