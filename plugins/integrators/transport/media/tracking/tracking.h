#pragma once

#include <vector>

#include "transport/blocks/arena.h"
#include "transport/media/bodies/majorant_grid.h"
#include "transport/media/bodies/media_table.h"

namespace kinome::transport {

/// Collisions and transmittances in media that aren't uniform. Rays in the same medium advance
/// together: each goes to its next tentative collision, then the medium is evaluated at all of
/// these points by one call. Not thread-safe: use one per thread.
class Tracking {
 public:
  Tracking(const MediaTable& media, size_t rays);

  /// Adds a segment of a ray, for the next call of find_collisions() or find_transmittances().
  /// `random` is the seed of its random numbers.
  void add(uint32_t medium, const kinome::Vec3& o, const kinome::Vec3& d, float length,
           uint64_t random, uint32_t index);
  bool is_empty() const { return count_ == 0; }

  struct Collision {
    uint32_t index;
    float distance;
  };
  /// Delta tracking: samples the first collision of each segment. Tentative collisions have the
  /// rate of the block's majorant. They are real with the mean probability of the channels,
  /// weighted by the throughput of the path `index`, which is divided by this mean. So the sum of
  /// the channels doesn't depend on the outcome, except for the albedo. `optical_depth` is that of
  /// the first tentative collision; the function sets it to that of the next one. The result is
  /// valid until the next call.
  const std::vector<Collision>& find_collisions(const Columns3& throughput, float* optical_depth);

  /// Residual ratio tracking (Novák et al. 2014): multiplies `transmittance` of each index by an
  /// unbiased estimate. The minorant of each block is integrated exactly. Tentative collisions have
  /// the rate of the majorant minus the minorant. Russian roulette ends small products.
  void find_transmittances(const Columns3& transmittance);

 private:
  struct Walk {
    BlockWalk along;
    uint32_t index;
    float left = 0;      ///< optical depth to the next tentative collision
    float majorant = 0;  ///< majorant of the current block
    float minorant = 0;
    float passed = 0;  ///< optical depth of the minorants on the way
    kinome::Rgb transmittance{1.f};
  };
  void evaluate(const Medium& medium, const std::vector<Walk>& walks);
  bool is_real(Walk& walk, size_t i, const Columns3& throughput);
  static bool attenuate(Walk& walk, const kinome::Rgb& extinction);

  const MediaTable& media_;
  std::vector<std::vector<Walk>> walks_;  ///< for each medium
  std::vector<Collision> collisions_;
  size_t count_ = 0;
  Arena arena_;
  Columns3 p_, d_, extinction_, scattering_;
};

}  // namespace kinome::transport
