#pragma once

#include <vector>

#include "kinome/film.h"
#include "kinome/math.h"
#include "kinome/reconstruction_filter.h"

namespace kinome {

/// Draws places of samples around a pixel's centre with the density of the film's filter, so that
/// each sample counts for its own pixel alone, whatever their number in the next pixel ("filter
/// importance sampling", Ernst et al. 2006).
///
/// Where a filter is negative, no density can follow it: it is the difference of two that can. A
/// pixel is then the mean over samples of the one, times its share, less that over samples of the
/// other, times its own. With a number of each that is fixed, an even surface has no noise by it.
/// Immutable.
class FilterSampler {
 public:
  explicit FilterSampler(const ReconstructionFilter& filter);

  /// Integrals of what is positive and of what is negative, the whole being 1.
  struct Shares {
    float positive = 1, negative = 0;
    /// Of `samples`, how many are for the negative part: as its share, but one at least of each,
    /// where there is such a part and samples for both.
    uint32_t negative_of(uint32_t samples) const;
  };
  bool has_negative() const { return !negative_.empty(); }
  /// Of pixel (x, y), which lies in `region`: there the filter is cut off and normalised again, as
  /// the film's weighted mean is.
  Shares shares(int x, int y, const Rect& region) const;
  /// Film position of a sample of the positive part.
  Vec2 place(int x, int y, const Vec2& u, const Rect& region) const;
  /// And of the negative one, where there is one.
  Vec2 place_negative(int x, int y, const Vec2& u, const Rect& region) const;

 private:
  static constexpr int kBins = 4096;
  /// Where the filter is positive along an axis, or where it is negative.
  class Part {
   public:
    Part() = default;
    /// `sign` times the filter, where that is positive.
    Part(const ReconstructionFilter& filter, float sign);
    bool empty() const { return !(total_ > 0); }
    float place(int pixel, float u, int low, int high) const;
    /// Integral between these places, in units that all parts of a filter share.
    double mass(int pixel, int low, int high) const;

   private:
    /// Of [low, high], as far as it lies within the filter: the cumulated at both ends.
    void cut(int pixel, int low, int high, float& begin, float& end) const;
    float cumulated(float offset) const;
    float radius_ = 0;
    bool is_box_ = false;
    double total_ = 0;
    std::vector<float> cumulated_;  ///< from -radius to each bin's end
  };

  Part positive_, negative_;
};

}  // namespace kinome
