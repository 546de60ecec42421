#pragma once

#include <span>
#include <vector>

#include "clustered/product/rays/comb.h"
#include "clustered/product/rays/strata.h"

namespace kinome {

/// Rays to one segment of the strata.
struct SegmentHits {
  const Strata::Segment& segment;
  std::span<const Comb::Hit> hits;  ///< their strata are relative to the segment's first one
  const float* weights;             ///< of the segment's strata
  float step;                       ///< weight / step is the expected number of hits of a stratum
  size_t before;                    ///< number of hits on the previous segments
};

/// Limits the weights of candidates to the step of a comb with this number of rays. A candidate is
/// one direction, so that a second ray along it would find nothing new. Each limited candidate gets
/// one ray, and the other strata get the remaining rays. Strata of cells, which contain many
/// directions, are not limited. Returns the step, or 0 if all weights are 0.
double cap_candidates(Strata& strata, size_t rays);

/// Selects the strata of a unit that get its shadow rays. One comb over all strata makes neighbours
/// on the line a stratified set. Reuses its memory; one object per thread.
class RayComb {
 public:
  /// Calls fn(SegmentHits) for each segment, in order. There are about `rays` hits in total;
  /// limited weights may change this number slightly. `offset` in [0, 1) is a random number.
  template <class Function>
  void walk(Strata& strata, size_t rays, double offset, const Function& fn) {
    const double step = rays > 0 ? cap_candidates(strata, rays) : 0;
    if (!(step > 0)) return;
    Comb comb = Comb::by_step(step, offset);
    size_t before = 0;
    for (const Strata::Segment& segment : strata.segments()) {
      const Strata::Columns columns = strata.columns(segment);
      hits_.clear();
      comb.pass(columns.weights, columns.block_sums, segment.size, hits_);
      fn(SegmentHits{segment, hits_, columns.weights, static_cast<float>(step), before});
      before += hits_.size();
    }
  }

 private:
  std::vector<Comb::Hit> hits_;
};

}  // namespace kinome
