#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/media/fog_sources.h"
#include "clustered/media/segment_distances.h"
#include "transport/arena.h"
#include "transport/media/segments.h"

namespace kinome {

/// Importance of each source, and of each part of a ray in a medium, for the light that the medium
/// scatters toward the ray's origin. It is estimated for some rays of a block without visibility,
/// then learned from candidates with known results. One per thread.
///
/// The parts (bins) of a ray have equal integrals of 1/r² for near sources, and of exp(-extinction
/// t) for distant ones. Near sources are also weighted for each ray, by the integral of 1/r² along
/// it. All probabilities are positive where light may come from.
class FogTable {
 public:
  static constexpr uint32_t kBins = 16;
  static constexpr uint32_t kNoBin = kBins;  ///< of distances from which hardly any light comes

  FogTable(const FogSources& sources, const transport::MediaTable& media);

  /// Computes importances that assume that nothing is in the light's way.
  void begin(std::span<const transport::MediumLeg> legs);

  /// Sets importances for rays that have nothing in common: the distribution of distances to near
  /// sources is equiangular, and the phase function is that of each ray. `visibility`: as
  /// visibility() of another table; 1 if it is empty.
  void begin_unrelated(std::span<const float> visibility);

  /// Position and source of a candidate.
  struct Choice {
    uint32_t source;
    uint32_t bin;
    float t;        ///< distance along the ray
    float density;  ///< probability of the source x density of t, per unit of length
    /// Factor from the candidate's light (relative to that which leaves the ray's beginning) to its
    /// ratio to the bin's expected light, for learn().
    float scale;
  };
  /// Sets the ray for choose().
  void set_leg(const transport::MediumLeg& leg);
  Choice choose(float u_source, float u_distance) const;
  /// Expected light of the ray, with an unknown factor that is the same for all rays. Visibility is
  /// included as far as it was learned.
  float expected_light() const { return near_total_ + sun_total_ + distant_total_; }

  /// Records the light of a candidate, including its visibility.
  void record(const Choice& choice, float light);
  /// Updates the importances from all records since begin().
  void learn();
  /// Learned mean transmittance, including visibility, to each group of distant sources.
  std::span<const float> visibility() const { return seen_; }

 private:
  using Bins = std::array<float, kBins>;
  struct Record {
    Bins squares{}, counts{};
  };
  Choice choose_near(uint32_t source, float probability, float u) const;
  Choice choose_sun(uint32_t index, float probability, float u) const;
  Choice choose_distant(uint32_t index, float probability, float u) const;
  void weigh_sky();
  Choice choose_from_sky(float at, float total, float u) const;
  void add_expected(const transport::MediumLeg& leg, uint32_t near);
  void set_near_probabilities();
  void set_distant_probabilities();
  float phase_toward(const transport::MediumLeg& leg, const Vec3& d, float mean_cosine) const;

  const FogSources& sources_;
  const transport::MediaTable& media_;
  transport::Arena arena_;
  Columns3 near_p_;
  float *nearest_, *near_weight_, *near_importance_;
  std::vector<Bins> expected_;  ///< light of near sources in each bin, relative to the sum
  std::vector<Bins> near_bins_, distant_bins_;  ///< probabilities of bins
  std::vector<Record> near_records_, distant_records_;
  std::vector<float> expected_weight_;   ///< of near sources
  std::vector<float> distant_expected_;  ///< flux x phase function
  std::vector<float> seen_;              ///< see visibility()
  std::vector<float> distant_sum_;       ///< running sum of the importances

  bool is_related_ = true;  ///< false after begin_unrelated()
  /// Distant sources without a grid, for rays that are unrelated: columns.
  transport::Arena sky_arena_;
  Columns3 sky_d_;
  float *sky_mean_cosine_, *sky_flux_, *sky_weight_;
  transport::MediumLeg leg_{};
  AttenuatedDistances attenuated_{1, 1};
  float extinction_ = 0, length_ = 0, reach_ = 0, absorbed_ = 0, albedo_ = 0;
  float near_total_ = 0, sun_total_ = 0, distant_total_ = 0;
  std::vector<float> sun_importance_;                  ///< of FogSources::suns(), for the ray
  std::vector<std::vector<SunGrid::Part>> sun_parts_;  ///< of the ray
};

/// Extinction of the channel with the longest way, of those with any extinction. Densities of
/// distances that fall like its transmittance are positive enough for all channels.
inline float least_extinction(const Rgb& extinction) {
  float least = kInfinity;
  for (int c = 0; c < 3; ++c) {
    if (extinction[c] > 0) least = std::min(least, extinction[c]);
  }
  return least;
}

}  // namespace kinome
