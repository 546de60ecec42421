#pragma once

#include <span>
#include <vector>

#include "clustered/product/comb.h"
#include "clustered/product/strata.h"

namespace kinome {

/// Rays that fell on one segment of the strata.
struct SegmentHits {
  const Strata::Segment& segment;
  std::span<const Comb::Hit> hits;  ///< strata are numbered from the segment's first on
  const float* weights;             ///< of the segment's strata
  float step;                       ///< weight / step is the expected number of hits of a stratum
  size_t before;                    ///< hits on the segments before
};

/// A candidate is one direction: a second ray along it would tell nothing new. Lowers weights of
/// candidates that are above the step of a comb of so many rays to that step, so that each gets one
/// ray, and the others get more; strata of cells, which hold many directions, stay. Returns the
/// step; 0: all weights are 0.
double cap_candidates(Strata& strata, size_t rays);

/// Decides which strata of a unit get its shadow rays: by one comb over all of them, so that
/// neighbours on the line are sampled as one stratified set. Keeps its memory: one per thread.
class RayComb {
 public:
  /// Calls fn(SegmentHits) for each segment, in their order. About `rays` hits in all; where
  /// weights are capped there may be some more or fewer. `offset` in [0, 1) is the random number.
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
