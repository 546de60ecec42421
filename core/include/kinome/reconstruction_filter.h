#pragma once

#include "kinome/object.h"

namespace kinome {

/// Separable, symmetric reconstruction filter. It need not be normalised, because films divide by
/// the sum of weights.
class KINOME_EXPORT ReconstructionFilter : public Object {
 public:
  /// Half width in pixels; eval() is 0 beyond it.
  float radius() const { return radius_; }
  /// Weight at offset x from the pixel's centre, in pixels.
  virtual float eval(float x) const = 0;
  /// Evaluates eval() for each x (see columns.h). Default: one by one.
  virtual void eval_block(const float* x, size_t count, float* out) const;
  /// Numerical integral of eval() over [low, high]; both may be infinite.
  double integral(double low, double high) const;

 protected:
  float radius_ = 0.5f;
};

}  // namespace kinome
