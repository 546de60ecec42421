#include "clustered/product/plan.h"

#include <algorithm>
#include <cmath>

namespace kinome {
namespace {

/// The error of n stratified points falls faster than 1 / n, and forecasts are rough: numbers go
/// with less than the root of the variance.
constexpr float kExponent = 0.4f;
constexpr float kPrimaryFactor = 1.5f;
constexpr float kSharpPrimaryFactor = 4;
constexpr float kRayFactor = 15;
constexpr float kCandidatesPerRay = 6;
/// Primaries are no fewer than this share of the candidates.
constexpr float kPrimariesPerCandidate = 0.03f;
constexpr float kMinCandidates = 16, kMaxCandidates = 3500;
constexpr float kMaxPrimaries = 256, kMaxRays = 1024;
constexpr float kMinRays = 2;

struct Wanted {
  float primaries, rays, candidates;
};

/// Reads a map with its border repeated, in units of what is typical for it: squares of the
/// faintest and the brightest light stay within a float.
class Neighbours {
 public:
  Neighbours(const std::vector<PixelForecast>& forecast, int width, int height, double unit)
      : forecast_(forecast), width_(width), height_(height), scale_(1 / unit) {}
  PixelForecast operator()(int x, int y) const {
    x = std::clamp(x, 0, width_ - 1);
    y = std::clamp(y, 0, height_ - 1);
    PixelForecast p = forecast_[static_cast<size_t>(y) * width_ + x];
    p.mean = static_cast<float>(p.mean * scale_);
    p.deviation = static_cast<float>(p.deviation * scale_);
    p.uncertainty = static_cast<float>(p.uncertainty * scale_);
    p.glossy_deviation = static_cast<float>(p.glossy_deviation * scale_);
    return p;
  }

 private:
  const std::vector<PixelForecast>& forecast_;
  int width_, height_;
  double scale_;
};

float squared_gradient(const Neighbours& at, int x, int y) {
  const auto along = [&](int dx, int dy) {
    const float d = at(x + dx, y + dy).mean - at(x - dx, y - dy).mean;
    return d * d;
  };
  return std::max({along(1, 0), along(0, 1), along(1, 1), along(1, -1)});
}

/// Expectations around a pixel: over 3x3 pixels, or 5x5 where lobes are sharp.
Wanted wanted_at(const Neighbours& at, int x, int y) {
  const PixelForecast here = at(x, y);
  const int reach = here.sharp ? 2 : 1;
  float mean = 0, mean2 = 0, variance = 0, uncertainty = 0, glossy = 0;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const PixelForecast p = at(x + dx, y + dy);
      mean += p.mean;
      mean2 += p.mean * p.mean;
      variance += p.deviation * p.deviation;
      uncertainty += p.uncertainty;
      glossy += p.glossy_deviation * p.glossy_deviation;
    }
  }
  const auto n = static_cast<float>((2 * reach + 1) * (2 * reach + 1));
  mean /= n;
  variance /= n;
  uncertainty /= n;
  glossy /= n;
  float own = here.deviation * here.deviation, level = here.mean, factor = kPrimaryFactor;
  if (here.sharp) {
    own = variance + 0.5f * std::max(0.f, mean2 / n - mean * mean);
    level = mean;
    factor = kSharpPrimaryFactor;
  }
  const float relative = 1 / (level * level + 0.01f);
  const float edges = squared_gradient(at, x, y) / 16;
  const auto power = [](float v) { return v > 0 ? std::pow(v, kExponent) : 0.f; };
  Wanted wanted;
  wanted.candidates = power(glossy * relative);
  wanted.rays = power(kRayFactor * uncertainty * uncertainty * relative);
  wanted.primaries = std::max(power(factor * (0.5f * (variance + own) + edges) * relative),
                              kPrimariesPerCandidate * kCandidatesPerRay * wanted.candidates);
  return wanted;
}

}  // namespace

std::vector<PixelPlan> allocate(const std::vector<PixelForecast>& forecast, int width, int height,
                                double rays_per_pixel, bool adaptive) {
  const size_t count = forecast.size();
  double mean = 0, uncertainty = 0;
  for (const PixelForecast& p : forecast) {
    mean += p.mean;
    uncertainty += p.uncertainty;
  }
  // Where no light is expected at all, doubt is all that there is to go by.
  const double unit = mean > 0 ? mean : uncertainty > 0 ? uncertainty : 1.;
  const Neighbours at(forecast, width, height, unit / static_cast<double>(count));
  std::vector<Wanted> wanted(count);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const size_t i = static_cast<size_t>(y) * width + x;
      wanted[i] = wanted_at(at, x, y);
      if (!adaptive) {
        wanted[i].primaries = 0.2f;
        wanted[i].rays = wanted[i].rays > 0 ? 1.f : 0.f;
      }
    }
  }
  // What the pilot missed of a thin object must not weigh too much when a later ray meets it.
  const auto min_primaries =
      static_cast<float>(std::clamp(rays_per_pixel / 8, rays_per_pixel < 8 ? 1. : 2., 32.));
  const auto primaries = [&](const Wanted& w, double scale) {
    return std::clamp(static_cast<float>(w.primaries * scale), min_primaries, kMaxPrimaries);
  };
  const auto rays = [&](const Wanted& w, double scale) {
    return w.rays > 0 ? std::clamp(static_cast<float>(w.rays * scale), kMinRays, kMaxRays) : 0.f;
  };
  double low = 1e-9, high = 1e12;
  for (int i = 0; i < 60; ++i) {
    const double scale = std::sqrt(low * high);
    double total = 0;
    for (size_t k = 0; k < count; ++k) {
      total += primaries(wanted[k], scale) * (1 + forecast[k].mirrors) + rays(wanted[k], scale);
    }
    (total > rays_per_pixel * static_cast<double>(count) ? high : low) = scale;
  }
  std::vector<PixelPlan> plan(count);
  // What rounding takes from one pixel is given to the next: pixels that are all alike would
  // otherwise all miss the budget in one direction.
  float more_primaries = 0, more_rays = 0;
  const auto round = [](float wish, float& more) {
    const auto whole = static_cast<uint16_t>(std::lround(wish + more));
    more += wish - static_cast<float>(whole);
    return whole;
  };
  for (size_t i = 0; i < count; ++i) {
    const Wanted& w = wanted[i];
    plan[i].primaries = round(primaries(w, low), more_primaries);
    if (w.rays > 0) plan[i].rays = round(rays(w, low), more_rays);
    plan[i].candidates = std::clamp(static_cast<float>(kCandidatesPerRay * w.candidates * low),
                                    kMinCandidates, kMaxCandidates);
  }
  return plan;
}

}  // namespace kinome
