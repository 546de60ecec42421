#include "clustered/product/trial/pixel_filter.h"

namespace kinome {

PixelFilter::PixelFilter(const ReconstructionFilter& filter) {
  float sum = 0;
  for (int d = -kReach; d <= kReach; ++d) {
    weights_[kReach + d] = static_cast<float>(filter.integral(d - 0.5, d + 0.5));
    sum += weights_[kReach + d];
  }
  for (float& weight : weights_) weight /= sum;
}

float PixelFilter::variance() const {
  float squares = 0;
  for (const float weight : weights_) squares += sqr(weight);
  return sqr(squares);
}

}  // namespace kinome
