#include "clustered/product/filter_sampler.h"

#include <algorithm>
#include <cmath>

namespace kinome {

FilterSampler::FilterSampler(const ReconstructionFilter& filter) : radius_(filter.radius()) {
  cumulated_.resize(kBins + 1);
  double sum = 0;
  is_box_ = true;
  for (int i = 0; i < kBins; ++i) {
    const float x = radius_ * (2 * (static_cast<float>(i) + 0.5f) / kBins - 1);
    const float value = std::max(0.f, filter.eval(x));
    is_box_ = is_box_ && value == filter.eval(0);
    sum += value;
    cumulated_[i + 1] = static_cast<float>(sum);
  }
  for (float& c : cumulated_) c = static_cast<float>(c / sum);
}

float FilterSampler::cumulated(float offset) const {
  const float at = std::clamp((offset / radius_ + 1) * 0.5f, 0.f, 1.f) * kBins;
  const int bin = std::min(static_cast<int>(at), kBins - 1);
  return cumulated_[bin] + (cumulated_[bin + 1] - cumulated_[bin]) * (at - static_cast<float>(bin));
}

float FilterSampler::place_1d(int pixel, float u, int low, int high) const {
  const float centre = static_cast<float>(pixel) + 0.5f;
  float begin = 0, end = 1;
  if (centre - radius_ < static_cast<float>(low))
    begin = cumulated(static_cast<float>(low) - centre);
  if (centre + radius_ > static_cast<float>(high)) {
    end = cumulated(static_cast<float>(high) - centre);
  }
  const float share = begin + (end - begin) * u;
  float at;
  if (is_box_) {
    at = share * 2 * radius_ - radius_;
  } else {
    const auto above = std::upper_bound(cumulated_.begin() + 1, cumulated_.end() - 1, share);
    const auto bin = static_cast<int>(above - cumulated_.begin()) - 1;
    const float width = cumulated_[bin + 1] - cumulated_[bin];
    const float part = width > 0 ? (share - cumulated_[bin]) / width : 0.5f;
    at = radius_ * (2 * (static_cast<float>(bin) + std::min(part, 1.f)) / kBins - 1);
  }
  // Far from the origin, sums round up to the filter's end, which is the next pixel's of a box.
  const float last = std::min(static_cast<float>(high), centre + radius_);
  return std::clamp(centre + at, static_cast<float>(low), std::nextafter(last, 0.f));
}

Vec2 FilterSampler::place(int x, int y, const Vec2& u, const Rect& region) const {
  return {place_1d(x, u.x, region.x0, region.x1), place_1d(y, u.y, region.y0, region.y1)};
}

}  // namespace kinome
