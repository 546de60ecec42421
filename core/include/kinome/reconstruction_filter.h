#pragma once

#include "kinome/object.h"

namespace kinome {

/// Separable, symmetric film filter. Not necessarily normalised: films divide by summed weights.
class KINOME_EXPORT ReconstructionFilter : public Object {
 public:
  /// Half width in pixels; eval is zero beyond it.
  float radius() const { return radius_; }
  virtual float eval(float x) const = 0;
  /// eval of each x (columns.h). Default: one by one.
  virtual void eval_block(const float* x, size_t count, float* out) const;
  /// Of eval over [low, high], numerically; both may be infinite.
  double integral(double low, double high) const;

 protected:
  float radius_ = 0.5f;
};

}  // namespace kinome
