#include "kinome/reconstruction_filter.h"

namespace kinome {

// The midpoint rule: exact for box and tent, and far below float's accuracy for smooth filters that
// end at zero.
double ReconstructionFilter::integral() const {
  constexpr int kSteps = 4096;
  const double step = 2.0 * radius_ / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += eval(static_cast<float>((i + 0.5) * step - radius_));
  return sum * step;
}

}  // namespace kinome
