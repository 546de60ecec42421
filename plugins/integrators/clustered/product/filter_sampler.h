#pragma once

#include <vector>

#include "kinome/film.h"
#include "kinome/math.h"
#include "kinome/reconstruction_filter.h"

namespace kinome {

/// Draws places of samples around a pixel's centre with the density of the film's filter, so that
/// each sample counts for its own pixel alone, whatever their number in the next pixel ("filter
/// importance sampling", Ernst et al. 2006). Filters must not be negative. Immutable.
class FilterSampler {
 public:
  explicit FilterSampler(const ReconstructionFilter& filter);
  /// Film position of a sample of pixel (x, y), which lies in `region`: there the filter is cut off
  /// and normalised again, as the film's weighted mean is.
  Vec2 place(int x, int y, const Vec2& u, const Rect& region) const;

 private:
  static constexpr int kBins = 4096;
  float place_1d(int pixel, float u, int low, int high) const;
  float cumulated(float offset) const;
  float radius_;
  bool is_box_;
  std::vector<float> cumulated_;  ///< of the filter from -radius to each bin's end
};

}  // namespace kinome
