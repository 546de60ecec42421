#pragma once

#include <array>
#include <cstdint>

#include "audit/object_audit.h"

namespace kinome {

/// Statistical test of whether samples follow the density p that a plugin returns.
///
/// Let q be the density of uniform directions, and g any function with values in [0, 1]. Then
///     E_sample[g q / (q + p)] = ∫ g p q / (q + p) = E_uniform[g p / (q + p)].
/// Both terms are in [0, 1] however peaked p is, so the test also works for a small sun. Each pair
/// of a sampled and a uniform direction gives a difference with mean 0, whichever point it is from.
/// The mean of the differences is compared with the empirical Bernstein bound (Maurer and Pontil
/// 2009, theorem 4), for g = 1 and for the half of the sphere along each axis.
class DensityAudit {
 public:
  /// Adds pairs of directions at a point.
  void add_place(const Bsdf& bsdf, const AuditPlace& place);
  /// The same for an environment.
  void add_place(const Emitter& emitter, const AuditPlace& place);
  /// Adds the pairs of another test of the same object.
  void add(const DensityAudit& other);
  /// Returns true if the samples don't follow the density. The probability of a false alarm is at
  /// most 1e-9.
  bool fails() const;

 private:
  static constexpr size_t kFunctions = 4;
  struct Terms {
    std::array<double, kFunctions> values{};
    /// Adds `share`, which is q / (q + p) for a sampled direction and -p / (q + p) for a uniform
    /// one.
    void add(const Vec3& d, double share);
  };
  void add(const Terms& pair);
  uint64_t count_ = 0;
  std::array<double, kFunctions> sums_{};
  std::array<double, kFunctions> squares_{};
};

}  // namespace kinome
