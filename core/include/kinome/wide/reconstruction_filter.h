#pragma once

#include "kinome/reconstruction_filter.h"
#include "kinome/wide/vectors.h"

namespace kinome::wide {

/// Reconstruction filter given by a formula, written once. `Derived`, a final class, has a public
///
///     template <class F> F weight(F x) const     // 0 beyond the radius
///
/// for F = float (one position) and wide::Float (a vector of positions).
template <class Derived>
class FormulaFilter : public ReconstructionFilter {
 public:
  float eval(float x) const final { return self().weight(x); }
  void eval_block(const float* x, size_t count, float* out) const final {
    for_lanes(count, [&](size_t i) { self().weight(Float::load(x + i)).store(out + i); });
  }

 private:
  const Derived& self() const { return static_cast<const Derived&>(*this); }
};

}  // namespace kinome::wide
