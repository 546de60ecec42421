#include "clustered/product/pilot/plan.h"

#include <algorithm>
#include <cmath>

#include "kinome/scheduler.h"
#include "kinome/wide/functions.h"
#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

/// Exponent of the variance in numbers of rays. It is less than 1/2, because the error of n
/// stratified points falls faster than 1 / n, and forecasts are rough.
constexpr float kExponent = 0.4f;
constexpr float kPrimaryFactor = 1.5f;
constexpr float kSharpPrimaryFactor = 4;
constexpr float kRayFactor = 15;
constexpr float kCandidatesPerRay = 6;
/// Minimum number of primaries per candidate.
constexpr float kPrimariesPerCandidate = 0.03f;
constexpr float kMinCandidates = 16, kMaxCandidates = 3500;
constexpr float kMaxPrimaries = 256, kMaxRays = 1024;
/// Minimum numbers of shadow rays of a pixel that needs any, from kMinRaysForTwo rays per pixel on
/// and below.
constexpr float kMinRays = 2, kMinRaysOfFew = 1;
/// Rays per pixel from which on each pixel has two primaries and two shadow rays or more.
constexpr double kMinRaysForTwo = 8;
/// Weight of the neighbours if forecasts are smoothed.
constexpr float kSmoothing = 0.7f;

/// Number of bisection steps that find the scale for the budget, between kMinScale and kMaxScale.
/// They give more digits than a float has.
constexpr int kSteps = 32;
constexpr double kMinScale = 1e-9, kMaxScale = 1e12;
static_assert(kSteps % 2 == 0);

/// Minimum number of pixels, and maximum number, of the parts of an image.
constexpr size_t kPixelsOfPart = 1 << 12, kMaxParts = 64;

using namespace wide;

/// Weight of the squared errors of a pixel. Its mean is in units of the image's mean.
template <class Number>
Number weight_of_errors(const Number& mean) {
  return 1.f / (mean * mean + 0.01f);
}

/// Five rows of an image's forecast, as columns. The unit is the image's mean, so that squares of
/// the faintest and the brightest light stay in the range of a float. Repeats the pixels at the
/// border outside the image.
class Maps {
 public:
  static constexpr int kBorder = 2;

  Maps(std::span<const PixelForecast> forecast, int width, int height, double unit, int first_row)
      : forecast_(forecast),
        width_(width),
        height_(height),
        scale_(1 / unit),
        stride_(padded(static_cast<size_t>(width) + 2 * kBorder)) {
    for (auto* const map : {&mean_, &variance_, &weight_, &uncertainty_, &glossy_, &sharp_}) {
      map->resize(stride_ * kRows + kBlockLanes);
    }
    for (int y = -kBorder; y < kBorder; ++y) read(first_row + y);
  }

  /// Reads the rows that row y needs. Must be called for the first row and each following one
  /// before the functions below read that row.
  void go_to(int y) { read(y + kBorder); }

  /// Values of pixel (x, y) and the next ones in its row.
  Float mean(int x, int y) const { return Float::load(&mean_[at(x, y)]); }
  /// Weight of the pixel's squared errors.
  Float weight(int x, int y) const { return Float::load(&weight_[at(x, y)]); }
  Float variance(int x, int y) const { return Float::load(&variance_[at(x, y)]); }
  Mask is_sharp(int x, int y) const { return Float::load(&sharp_[at(x, y)]) > 0.f; }

  /// Means over the pixels within `reach`.
  struct Around {
    Float mean, squared_mean, variance, uncertainty, glossy, weight;
  };
  Around around(int x, int y, int reach) const {
    Around sums{0, 0, 0, 0, 0, 0};
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const size_t i = at(x + dx, y + dy);
        const Float m = Float::load(&mean_[i]);
        sums.mean += m;
        sums.squared_mean += m * m;
        sums.variance += Float::load(&variance_[i]);
        sums.uncertainty += Float::load(&uncertainty_[i]);
        sums.glossy += Float::load(&glossy_[i]);
        sums.weight += Float::load(&weight_[i]);
      }
    }
    const Float share = 1.f / static_cast<float>((2 * reach + 1) * (2 * reach + 1));
    for (Float* const sum : {&sums.mean, &sums.squared_mean, &sums.variance, &sums.uncertainty,
                             &sums.glossy, &sums.weight}) {
      *sum *= share;
    }
    return sums;
  }

  Float squared_gradient(int x, int y) const {
    const auto along = [&](int dx, int dy) {
      return sqr(mean(x + dx, y + dy) - mean(x - dx, y - dy));
    };
    return max(max(along(1, 0), along(0, 1)), max(along(1, 1), along(1, -1)));
  }

 private:
  static constexpr int kRows = 2 * kBorder + 1;

  void read(int y) {
    const PixelForecast* const row =
        &forecast_[static_cast<size_t>(std::clamp(y, 0, height_ - 1)) * width_];
    for (int x = -kBorder; x < width_ + kBorder; ++x) {
      const PixelForecast& p = row[std::clamp(x, 0, width_ - 1)];
      const size_t i = at(x, y);
      mean_[i] = static_cast<float>(p.mean * scale_);
      variance_[i] = sqr(static_cast<float>(p.deviation * scale_));
      weight_[i] = weight_of_errors(mean_[i]);
      uncertainty_[i] = static_cast<float>(p.uncertainty * scale_);
      glossy_[i] = sqr(static_cast<float>(p.glossy_deviation * scale_));
      sharp_[i] = p.sharp ? 1.f : 0.f;
    }
  }
  size_t at(int x, int y) const {
    const auto row = static_cast<size_t>((y + kBorder) % kRows);
    return row * stride_ + static_cast<size_t>(x + kBorder);
  }

  std::span<const PixelForecast> forecast_;
  int width_, height_;
  double scale_;
  size_t stride_;
  Column<float> mean_, variance_, weight_, uncertainty_, glossy_, sharp_;
};

struct Wanted {
  Float primaries, rays, candidates;
};

Float power(Float v) {
  return select(v > 0.f, pow(v, kExponent));
}

/// Returns the unscaled numbers of a pixel. Uses means of the forecast over 3x3 pixels, or 5x5 if
/// lobes are sharp. The weight of the pixel's errors is its own, mixed with that of its neighbours
/// by `smoothing`. Averages these weights, not the brightness: otherwise, a dark pixel beside
/// bright ones would count as bright, and get too few rays.
Wanted wanted_at(const Maps& maps, int x, int y, float smoothing) {
  Maps::Around around = maps.around(x, y, 1);
  Float own = maps.variance(x, y), factor = kPrimaryFactor;
  Float relative = lerp(maps.weight(x, y), around.weight, Float(smoothing));
  // If the pilot found no light in a pixel, only its neighbours determine its brightness. Most such
  // pixels stay dark, and would take the rays of all others.
  relative = select(maps.mean(x, y) > 0.f, relative, weight_of_errors(smoothing * around.mean));
  const Mask is_sharp = maps.is_sharp(x, y);
  if (any(is_sharp)) {
    const Maps::Around wider = maps.around(x, y, 2);
    around.variance = select(is_sharp, wider.variance, around.variance);
    around.uncertainty = select(is_sharp, wider.uncertainty, around.uncertainty);
    around.glossy = select(is_sharp, wider.glossy, around.glossy);
    const Float of_means = max(wider.squared_mean - sqr(wider.mean), Float(0.f));
    own = select(is_sharp, wider.variance + 0.5f * of_means, own);
    relative = select(is_sharp, weight_of_errors(wider.mean), relative);
    factor = select(is_sharp, Float(kSharpPrimaryFactor), factor);
  }
  const Float edges = maps.squared_gradient(x, y) * (1 / 16.f);
  const Float candidates = power(around.glossy * relative);
  const Float variance = 0.5f * (around.variance + own) + edges;
  return {max(power(factor * variance * relative),
              kPrimariesPerCandidate * kCandidatesPerRay * candidates),
          power(kRayFactor * sqr(around.uncertainty) * relative), candidates};
}

/// Rounds a number plus the rounding error of the previous pixel, `rest`: otherwise, pixels that
/// are all alike would all miss the budget in one direction.
uint16_t rounded(float number, float& rest) {
  const auto whole = static_cast<uint16_t>(std::lround(number + rest));
  rest += number - static_cast<float>(whole);
  return whole;
}

}  // namespace

RayAllocation::RayAllocation(std::span<const PixelForecast> forecast, int width, int height,
                             Mode mode, const Scheduler& scheduler)
    : width_(static_cast<size_t>(width)),
      height_(static_cast<size_t>(height)),
      stride_(padded(width_)) {
  struct Sums {
    double mean = 0, uncertainty = 0;
  };
  std::vector<Sums> of_parts(parts());
  scheduler.parallel_for(parts(), [&](size_t part) {
    Sums sums;
    for (size_t i = first_row(part) * width_; i < first_row(part + 1) * width_; ++i) {
      sums.mean += forecast[i].mean;
      sums.uncertainty += forecast[i].uncertainty;
    }
    of_parts[part] = sums;
  });
  Sums all;
  for (const Sums& sums : of_parts) {
    all.mean += sums.mean;
    all.uncertainty += sums.uncertainty;
  }
  // If no light is expected, the uncertainty is the unit.
  const double unit = all.mean > 0 ? all.mean : all.uncertainty > 0 ? all.uncertainty : 1.;
  for (auto* const column : {&primaries_, &rays_, &candidates_, &costs_}) {
    column->resize(stride_ * height_);
  }
  const float smoothing = mode == Mode::kSmoothed ? kSmoothing : 0.f;
  scheduler.parallel_for(parts(), [&](size_t part) {
    const size_t begin = first_row(part), end = first_row(part + 1);
    Maps maps(forecast, width, height, unit / static_cast<double>(forecast.size()),
              static_cast<int>(begin));
    for (size_t y = begin; y < end; ++y) {
      maps.go_to(static_cast<int>(y));
      const size_t first = y * stride_;
      for (size_t x = 0; x < width_; ++x) costs_[first + x] = 1 + forecast[y * width_ + x].mirrors;
      for_lanes(width_, [&](size_t x) {
        Wanted wanted = wanted_at(maps, static_cast<int>(x), static_cast<int>(y), smoothing);
        if (mode == Mode::kEven) {
          wanted.primaries = 0.2f;
          wanted.rays = select(wanted.rays > 0.f, Float(1.f));
        }
        wanted.primaries.store(&primaries_[first + x]);
        wanted.rays.store(&rays_[first + x]);
        wanted.candidates.store(&candidates_[first + x]);
      });
    }
  });
}

size_t RayAllocation::parts() const {
  const size_t parts = std::min(width_ * height_ / kPixelsOfPart, kMaxParts);
  return std::clamp<size_t>(parts, 1, std::max<size_t>(1, height_));
}

Float RayAllocation::primaries(size_t i, float scale, float min_primaries) const {
  return clamp(Float::load(&primaries_[i]) * scale, Float(min_primaries), Float(kMaxPrimaries));
}
Float RayAllocation::rays(size_t i, float scale, float min_rays) const {
  const Float wanted = Float::load(&rays_[i]);
  return select(wanted > 0.f, clamp(wanted * scale, Float(min_rays), Float(kMaxRays)));
}
Float RayAllocation::candidates(size_t i, float scale) const {
  return clamp(kCandidatesPerRay * scale * Float::load(&candidates_[i]), Float(kMinCandidates),
               Float(kMaxCandidates));
}

/// Number of rays of all kinds of all pixels, for each scale.
std::array<double, RayAllocation::kScales> RayAllocation::totals(
    const std::array<float, kScales>& scales, float min_primaries, float min_rays,
    const Scheduler& scheduler) const {
  std::vector<std::array<double, kScales>> of_parts(parts());
  scheduler.parallel_for(parts(), [&](size_t part) {
    std::array<double, kScales> sums{};
    for (size_t y = first_row(part); y < first_row(part + 1); ++y) {
      Float of_row[kScales] = {0, 0, 0};
      for_lanes(width_, [&](size_t x) {
        const size_t i = y * stride_ + x;
        for (size_t k = 0; k < kScales; ++k) {
          const Float cost = primaries(i, scales[k], min_primaries) * Float::load(&costs_[i]) +
                             rays(i, scales[k], min_rays);
          of_row[k] += select(first_lanes(width_ - x), cost);
        }
      });
      for (size_t k = 0; k < kScales; ++k) sums[k] += sum(of_row[k]);
    }
    of_parts[part] = sums;
  });
  std::array<double, kScales> totals{};
  for (const auto& sums : of_parts) {
    for (size_t k = 0; k < kScales; ++k) totals[k] += sums[k];
  }
  return totals;
}

LargeArray<PixelPlan> RayAllocation::plan(double rays_per_pixel, const Scheduler& scheduler) const {
  // A minimum limits the weight of thin objects that the pilot missed and a later ray hits.
  const bool is_for_two = rays_per_pixel >= kMinRaysForTwo;
  const auto min_primaries =
      static_cast<float>(std::clamp(rays_per_pixel / 8, is_for_two ? 2. : 1., 32.));
  const float min_rays = is_for_two ? kMinRays : kMinRaysOfFew;
  const double budget = rays_per_pixel * static_cast<double>(width_ * height_);
  double low = kMinScale, high = kMaxScale;
  for (int i = 0; i < kSteps; i += 2) {
    const double middle = std::sqrt(low * high);
    const double below = std::sqrt(low * middle), above = std::sqrt(middle * high);
    const std::array<double, kScales> found =
        totals({static_cast<float>(below), static_cast<float>(middle), static_cast<float>(above)},
               min_primaries, min_rays, scheduler);
    (found[1] > budget ? high : low) = middle;
    if (found[1] > budget) {
      (found[0] > budget ? high : low) = below;
    } else {
      (found[2] > budget ? high : low) = above;
    }
  }
  const auto scale = static_cast<float>(low);
  LargeArray<PixelPlan> plan(width_ * height_);
  scheduler.parallel_for(parts(), [&](size_t part) {
    float rest_of_primaries = 0, rest_of_rays = 0;
    Column<float> of_primaries(stride_), of_rays(stride_), of_candidates(stride_);
    for (size_t y = first_row(part); y < first_row(part + 1); ++y) {
      for_lanes(width_, [&](size_t x) {
        const size_t i = y * stride_ + x;
        primaries(i, scale, min_primaries).store(&of_primaries[x]);
        rays(i, scale, min_rays).store(&of_rays[x]);
        candidates(i, scale).store(&of_candidates[x]);
      });
      for (size_t x = 0; x < width_; ++x) {
        PixelPlan p;
        p.primaries = rounded(of_primaries[x], rest_of_primaries);
        if (of_rays[x] > 0) p.rays = rounded(of_rays[x], rest_of_rays);
        p.candidates = of_candidates[x];
        plan[y * width_ + x] = p;
      }
    }
  });
  return plan;
}

}  // namespace kinome
