#include "clustered/product/filter_sampler.h"

#include <algorithm>
#include <cmath>

namespace kinome {

FilterSampler::Part::Part(const ReconstructionFilter& filter, float sign)
    : radius_(filter.radius()), is_box_(true) {
  cumulated_.resize(kBins + 1);
  for (int i = 0; i < kBins; ++i) {
    const float x = radius_ * (2 * (static_cast<float>(i) + 0.5f) / kBins - 1);
    const float value = std::max(0.f, sign * filter.eval(x));
    is_box_ = is_box_ && value == sign * filter.eval(0);
    total_ += value;
    cumulated_[i + 1] = static_cast<float>(total_);
  }
  for (float& c : cumulated_) c = static_cast<float>(c / total_);
}

float FilterSampler::Part::cumulated(float offset) const {
  const float at = std::clamp((offset / radius_ + 1) * 0.5f, 0.f, 1.f) * kBins;
  const int bin = std::min(static_cast<int>(at), kBins - 1);
  return cumulated_[bin] + (cumulated_[bin + 1] - cumulated_[bin]) * (at - static_cast<float>(bin));
}

void FilterSampler::Part::cut(int pixel, int low, int high, float& begin, float& end) const {
  const float centre = static_cast<float>(pixel) + 0.5f;
  begin = 0, end = 1;
  if (centre - radius_ < static_cast<float>(low))
    begin = cumulated(static_cast<float>(low) - centre);
  if (centre + radius_ > static_cast<float>(high)) {
    end = cumulated(static_cast<float>(high) - centre);
  }
}

double FilterSampler::Part::mass(int pixel, int low, int high) const {
  if (empty()) return 0;
  float begin, end;
  cut(pixel, low, high, begin, end);
  return total_ * (double{end} - begin);
}

float FilterSampler::Part::place(int pixel, float u, int low, int high) const {
  float begin, end;
  cut(pixel, low, high, begin, end);
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
  const float centre = static_cast<float>(pixel) + 0.5f;
  const float last = std::min(static_cast<float>(high), centre + radius_);
  return std::clamp(centre + at, static_cast<float>(low), std::nextafter(last, 0.f));
}

FilterSampler::FilterSampler(const ReconstructionFilter& filter) : positive_(filter, 1) {
  const Part negative(filter, -1);
  if (!negative.empty()) negative_ = negative;
}

uint32_t FilterSampler::Shares::negative_of(uint32_t samples) const {
  if (!(negative > 0) || samples < 2) return 0;
  const float wanted = static_cast<float>(samples) * negative / (positive + negative);
  return std::clamp(static_cast<uint32_t>(std::lround(wanted)), 1u, samples - 1);
}

FilterSampler::Shares FilterSampler::shares(int x, int y, const Rect& region) const {
  if (!has_negative()) return {};
  const double px = positive_.mass(x, region.x0, region.x1);
  const double py = positive_.mass(y, region.y0, region.y1);
  const double nx = negative_.mass(x, region.x0, region.x1);
  const double ny = negative_.mass(y, region.y0, region.y1);
  const double whole = (px - nx) * (py - ny);
  return {static_cast<float>((px * py + nx * ny) / whole),
          static_cast<float>((px * ny + nx * py) / whole)};
}

namespace {

/// Whether u lies below the share that `a` has of a + b; u becomes where it lies within its own.
bool is_of_first(double a, double b, float& u) {
  const auto share = static_cast<float>(a / (a + b));
  const bool is_first = u < share;
  const float within = is_first ? u / share : (u - share) / (1 - share);
  u = std::min(within, kOneMinusEpsilon);
  return is_first;
}

}  // namespace

// Of a product of two, the positive part is where both have one sign, ...
Vec2 FilterSampler::place(int x, int y, const Vec2& u, const Rect& region) const {
  float along_x = u.x;
  const Part* part = &positive_;
  if (has_negative()) {
    const double nx = negative_.mass(x, region.x0, region.x1);
    const double ny = negative_.mass(y, region.y0, region.y1);
    const double both = positive_.mass(x, region.x0, region.x1) *
                        positive_.mass(y, region.y0, region.y1);
    if (!is_of_first(both, nx * ny, along_x)) part = &negative_;
  }
  return {part->place(x, along_x, region.x0, region.x1),
          part->place(y, u.y, region.y0, region.y1)};
}

// ... and the negative part is where they differ.
Vec2 FilterSampler::place_negative(int x, int y, const Vec2& u, const Rect& region) const {
  float along_x = u.x;
  const double px = positive_.mass(x, region.x0, region.x1);
  const double py = positive_.mass(y, region.y0, region.y1);
  const double nx = negative_.mass(x, region.x0, region.x1);
  const double ny = negative_.mass(y, region.y0, region.y1);
  const bool is_negative_along_x = is_of_first(nx * py, px * ny, along_x);
  const Part& of_x = is_negative_along_x ? negative_ : positive_;
  const Part& of_y = is_negative_along_x ? positive_ : negative_;
  return {of_x.place(x, along_x, region.x0, region.x1), of_y.place(y, u.y, region.y0, region.y1)};
}

}  // namespace kinome
