#pragma once

#include <array>
#include <cstdint>

#include "plugin/object_audit.h"

namespace kinome {

/// Whether samples follow the density p that a plugin says they have, told from directions alone.
///
/// With the density q of uniform directions, and g any function within [0, 1],
///     E_sample[g q / (q + p)] = ∫ g p q / (q + p) = E_uniform[g p / (q + p)],
/// where both terms stay within [0, 1] however peaked p is: no sun is too small for that. Each pair
/// of directions, one sampled and one uniform, gives a difference of mean 0, also if pairs are of
/// different places. Means of these are compared with the empirical Bernstein bound (Maurer and
/// Pontil 2009, theorem 4), for g = 1 and for half of the sphere along each axis.
class DensityAudit {
 public:
  void look_at(const Bsdf& bsdf, const AuditPlace& place);
  /// An environment.
  void look_at(const Emitter& emitter, const AuditPlace& place);
  /// Sound plugins fail it once in 10^9 times.
  bool fails() const;

 private:
  static constexpr size_t kFunctions = 4;
  struct Terms {
    std::array<double, kFunctions> values{};
    /// Adds a direction with share q / (q + p) or p / (q + p), or takes it away.
    void add(const Vec3& d, double share);
  };
  void add(const Terms& pair);
  uint64_t count_ = 0;
  std::array<double, kFunctions> sums_{};
  std::array<double, kFunctions> squares_{};
};

}  // namespace kinome
