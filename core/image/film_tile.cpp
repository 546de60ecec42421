// Adds samples, blocks of samples, finished pixels and splats to tiles of a film.

#include <cmath>
#include <limits>
#include <stdexcept>

#include "image/film_pixels.h"
#include "kinome/color.h"
#include "scene/point_by_point.h"

namespace kinome {
namespace {

/// Filter weights along one axis, for each of up to kBlockLanes samples and each pixel that it
/// contributes to.
class AxisWeights {
 public:
  explicit AxisWeights(const ReconstructionFilter& filter)
      : filter_(filter),
        // The largest number of pixels of a footprint().
        offsets_(static_cast<size_t>(2 * filter.radius()) + 2),
        weights_(offsets_.size()) {}

  /// Computes the weights of `count` samples at `position` for the pixels in [begin, end).
  void compute(const float* position, size_t count, int begin, int end) {
    int widest = 0;
    for (size_t i = 0; i < count; ++i) {
      const double p = position[i];
      const Footprint pixels = footprint(p, p, filter_.radius());
      first_[i] = std::max(pixels.first, begin);
      pixels_[i] = std::max(std::min(pixels.end, end) - first_[i], 0);
      widest = std::max(widest, pixels_[i]);
      for (int k = 0; k < pixels_[i]; ++k) {
        offsets_[static_cast<size_t>(k)].values[i] = static_cast<float>(first_[i] + k + 0.5 - p);
      }
    }
    if (widest == 0) return;
    filter_.eval_block(offsets_.data()->values, static_cast<size_t>(widest) * kBlockLanes,
                       weights_.data()->values);
  }
  /// First pixel that sample i contributes to.
  int first(size_t i) const { return first_[i]; }
  /// Number of pixels that sample i contributes to.
  int pixels(size_t i) const { return pixels_[i]; }
  /// Weight of sample i for pixel first(i) + k.
  float at(size_t i, int k) const { return weights_[static_cast<size_t>(k)].values[i]; }

 private:
  struct alignas(kColumnAlignment) Lanes {
    float values[kBlockLanes] = {};
  };
  const ReconstructionFilter& filter_;
  int first_[kBlockLanes], pixels_[kBlockLanes];
  std::vector<Lanes> offsets_, weights_;  ///< by pixel of the footprint
};

/// Values of a sample, their powers, and 1 for the weight.
class SampleRow {
 public:
  SampleRow(size_t values, const std::vector<FilmPower>& powers)
      : powers_(powers), values_(values), row_(values + powers.size() + 1, 1.) {}

  void set(const float* values) {
    for (size_t i = 0; i < values_; ++i) row_[i] = values[i];
    for (size_t i = 0; i < powers_.size(); ++i) row_[values_ + i] = powers_[i](values);
  }
  /// Adds the sample to the sums of a pixel.
  void add_to(double* pixel, double weight) const {
    for (size_t i = 0; i < row_.size(); ++i) pixel[i] += weight * row_[i];
  }

 private:
  const std::vector<FilmPower>& powers_;
  size_t values_;
  std::vector<double> row_;
};

}  // namespace

double FilmPower::operator()(const float* values) const {
  const double base = value >= 0 ? double{values[value]}
                                 : xyz({values[0], values[1], values[2]})[value - FilmChannel::kX];
  double result = base;
  for (int i = 1; i < power; ++i) result *= base;
  return result;
}

FilmTile::FilmTile(const Rect& pixels, int layer, int values, const ReconstructionFilter& filter,
                   const Rect& crop, std::vector<FilmPower> powers)
    : pixels_(pixels),
      layer_(layer),
      values_(values),
      powers_(std::move(powers)),
      filter_(&filter) {
  const Footprint fx = footprint(pixels.x0, pixels.x1, filter.radius());
  const Footprint fy = footprint(pixels.y0, pixels.y1, filter.radius());
  covered_ = intersection({fx.first, fy.first, fx.end, fy.end}, crop);
  data_.assign(static_cast<size_t>(covered_.area()) * stride(), 0.);
}

void FilmTile::add(const Vec2& position, std::span<const float> values) {
  if (values.size() != static_cast<size_t>(values_)) {
    throw std::logic_error("FilmTile::add: wrong number of values");
  }
  bool finite = is_on_any_film(position);
  for (const float v : values) finite = finite && std::isfinite(v);
  if (!finite) {
    ++non_finite_;
    return;
  }
  SampleRow row(values.size(), powers_);
  row.set(values.data());
  for_each_pixel(position, *filter_, covered_, [&](int x, int y, float w) {
    row.add_to(&data_[pixel_offset(covered_, x, y, stride())], w);
  });
}

void FilmTile::add_block(const Columns2& position, size_t count,
                         std::span<const float* const> values) {
  if (values.size() != static_cast<size_t>(values_)) {
    throw std::logic_error("FilmTile::add_block: wrong number of values");
  }
  UpperHalves::clear();
  AxisWeights along_x(*filter_), along_y(*filter_);
  std::vector<float> of_sample(values.size());
  SampleRow row(values.size(), powers_);
  for (size_t next = 0; next < count;) {
    size_t number[kBlockLanes], kept = 0;
    float x[kBlockLanes], y[kBlockLanes];
    for (; next < count && kept < kBlockLanes; ++next) {
      bool finite = is_on_any_film(position.at(next));
      for (const float* column : values) finite = finite && std::isfinite(column[next]);
      if (finite) {
        x[kept] = position.x[next], y[kept] = position.y[next], number[kept++] = next;
      } else {
        ++non_finite_;
      }
    }
    along_x.compute(x, kept, covered_.x0, covered_.x1);
    along_y.compute(y, kept, covered_.y0, covered_.y1);
    for (size_t i = 0; i < kept; ++i) {
      for (size_t v = 0; v < values.size(); ++v) of_sample[v] = values[v][number[i]];
      row.set(of_sample.data());
      for (int j = 0; j < along_y.pixels(i); ++j) {
        const float wy = along_y.at(i, j);
        if (wy == 0 || along_x.pixels(i) == 0) continue;
        double* pixel =
            &data_[pixel_offset(covered_, along_x.first(i), along_y.first(i) + j, stride())];
        for (int k = 0; k < along_x.pixels(i); ++k, pixel += stride()) {
          row.add_to(pixel, wy * along_x.at(i, k));
        }
      }
    }
  }
}

void FilmTile::add_pixel(int x, int y, std::span<const float> values, float weight) {
  if (values.size() != static_cast<size_t>(values_)) {
    throw std::logic_error("FilmTile::add_pixel: wrong number of values");
  }
  bool finite = true;
  for (const float v : values) finite = finite && std::isfinite(v);
  if (!finite) {
    ++non_finite_;
    return;
  }
  if (x < covered_.x0 || x >= covered_.x1 || y < covered_.y0 || y >= covered_.y1) return;
  SampleRow row(values.size(), powers_);
  row.set(values.data());
  row.add_to(&data_[pixel_offset(covered_, x, y, stride())], weight);
}

void FilmTile::add_sums(int x, int y, std::span<const float> sums, float weight) {
  if (sums.size() != static_cast<size_t>(values_) || !powers_.empty()) {
    throw std::logic_error("FilmTile::add_sums: wrong number of values, or the layer has powers");
  }
  if (x < covered_.x0 || x >= covered_.x1 || y < covered_.y0 || y >= covered_.y1) return;
  double* const pixel = &data_[pixel_offset(covered_, x, y, stride())];
  for (int i = 0; i < values_; ++i) pixel[i] += static_cast<double>(sums[static_cast<size_t>(i)]);
  pixel[values_] += static_cast<double>(weight);
}

void FilmTile::add_splat(const Vec2& position, const Rgb& value) {
  if (!is_finite(value) || !is_finite(Vec3(position, 0.f))) {
    ++non_finite_;
    return;
  }
  if (is_on_any_film(position)) splats_.push_back({position, value});
}

}  // namespace kinome
