#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "clustered/media/segment_distances.h"
#include "clustered/media/sources/fog_sources.h"
#include "clustered/media/sources/sun_grid.h"
#include "clustered/media/sources/weighted_sources.h"
#include "kinome/columns.h"
#include "kinome/math.h"
#include "transport/blocks/arena.h"
#include "transport/media/bodies/media_table.h"
#include "transport/media/tracking/segments.h"

namespace kinome {

/// Importance of each source, and of each part of a ray in a medium, for the light that the medium
/// scatters toward the ray's origin. Importances are first estimated for some rays of a block,
/// without visibility, and then learned from candidates with known results. Not thread-safe: use
/// one per thread.
///
/// The parts (bins) of a ray have equal integrals of 1/r² for near sources, and of exp(-extinction
/// t) for distant ones. Near sources are also weighted for each ray, by the integral of 1/r² along
/// it. All probabilities are positive where light may come from.
class FogTable {
 public:
  static constexpr uint32_t kBins = 16;
  static constexpr uint32_t kNoBin = kBins;  ///< bin of distances from which hardly any light comes

  FogTable(const FogSources& sources, const transport::MediaTable& media);

  /// Computes importances without occlusion.
  void begin(std::span<const transport::MediumLeg> legs);

  /// Sets importances for unrelated rays, such as later edges of paths. The distribution of
  /// distances to near sources is then equiangular, and each ray has its own phase function.
  /// `visibility` is that of another table, or empty for 1.
  void begin_unrelated(std::span<const float> visibility);

  /// Position and source of a candidate.
  struct Choice {
    uint32_t source;
    uint32_t bin;
    float t;        ///< distance along the ray
    float density;  ///< probability of the source x density of t, per unit of length
    /// Factor that converts the candidate's light at the ray's origin to its ratio to the bin's
    /// expected light, for learn().
    float scale;
  };
  /// Sets the ray of choose() and expected_light().
  void set_leg(const transport::MediumLeg& leg);
  Choice choose(float u_source, float u_distance) const;
  /// Expected light of the ray, up to a factor that is the same for all rays. It includes learned
  /// visibility.
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
  float *nearest_, *near_weight_;
  WeightedSources near_importance_;  ///< importances for the ray
  std::vector<Bins> expected_;       ///< light of near sources in each bin, relative to the sum
  std::vector<Bins> near_bins_, distant_bins_;  ///< probabilities of bins
  std::vector<Record> near_records_, distant_records_;
  std::vector<float> expected_weight_;   ///< expected light of near sources
  std::vector<float> distant_expected_;  ///< flux x phase function
  std::vector<float> seen_;              ///< see visibility()
  std::vector<float> distant_sum_;       ///< running sum of the importances

  bool is_related_ = true;  ///< false after begin_unrelated()
  /// Columns of the distant sources without a grid, for unrelated rays.
  transport::Arena sky_arena_;
  Columns3 sky_d_;
  float *sky_mean_cosine_, *sky_flux_;
  WeightedSources sky_weight_;  ///< weights for the ray
  transport::MediumLeg leg_{};
  AttenuatedDistances attenuated_{1, 1};
  float extinction_ = 0, length_ = 0, reach_ = 0, absorbed_ = 0, albedo_ = 0;
  float near_scale_ = 1, near_total_ = 0, sun_total_ = 0, distant_total_ = 0;
  std::vector<float> sun_importance_;                  ///< for each of FogSources::suns()
  std::vector<std::vector<SunGrid::Part>> sun_parts_;  ///< parts of the ray
};

}  // namespace kinome
