#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "clustered/product/tiles/visibility.h"

namespace kinome {

class ProcessGroup;

/// Compares learned visibilities with the rays of the pilot. Measures (V - v)² / sigma² in a table
/// over sigma² and the class of v: hidden, visible or neither. The rays are compared with
/// predictions from the rays around them. The result depends on the scene: a wall with a window
/// needs rays at few cells, foliage at all.
///
/// Several threads may call add_record() at once, but not together with the other functions. Sums
/// are integers, so that their order doesn't matter.
class SigmaCheck {
 public:
  void forget();
  /// Adds a ray to a cell whose visibility was learned without it. v is in [0, 1];
  /// sigma is positive and at most 1.1.
  void add_record(float v, float sigma, float visible);
  /// Sums the table over all processes of a group.
  void sum_over_processes(ProcessGroup* group);
  /// Computes the factors of sigma. Call it after all add_record() and sum_over_processes().
  void finish();
  /// Corrects each sigma by the result. Doesn't change sigma_mixed, which is for v = 0. Does
  /// nothing before finish().
  void correct(Visibility& visibility) const;

 private:
  /// Steps are half octaves of sigma² below 1.
  static constexpr int kSteps = 40;
  static constexpr int kHidden = 0, kVisible = 1, kNeither = 2, kSides = 3;
  /// Integers, in units of 2^-32.
  struct Sums {
    std::atomic<uint64_t> expected = 0, found = 0;
  };
  std::array<Sums, kSides * kSteps> sums_;
  std::array<float, kSides * kSteps> factor_;  ///< of sigma²
  bool is_finished_ = false;
};

}  // namespace kinome
