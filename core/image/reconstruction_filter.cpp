#include "kinome/reconstruction_filter.h"

#include <algorithm>

namespace kinome {

// Uses the midpoint rule. It is exact for box and tent filters. For smooth filters that end at
// zero, its error is far below the precision of float.
double ReconstructionFilter::integral(double low, double high) const {
  constexpr int kSteps = 4096;
  const double radius = radius_;
  const double begin = std::clamp(low, -radius, radius);
  const double step = (std::clamp(high, -radius, radius) - begin) / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += eval(static_cast<float>(begin + (i + 0.5) * step));
  return sum * step;
}

}  // namespace kinome
