#pragma once

#include <algorithm>
#include <mutex>
#include <optional>
#include <vector>

#include "kinome/wide/distribution.h"
#include "kinome/wide/doubles.h"

namespace kinome {

/// Samples points of the unit square by the flux of an emitter through them. The density is
/// constant in each cell of a grid. Immutable; thread-safe.
class FluxGrid {
 public:
  /// flux(uv), in any unit and not negative, is evaluated at the corners of `parts` x `parts` parts
  /// of each cell. This is exact if it is bilinear in each part. If the corners differ by more than
  /// a factor of 2, an edge may cross the part: its centre then has half of the weight.
  template <class Flux>
  FluxGrid(glm::uvec2 cells, uint32_t parts, const Flux& flux) : cells_(cells) {
    const glm::uvec2 size = cells * parts;
    const auto at = [&](float x, float y) { return flux(Vec2(x, y) / Vec2(size)); };
    const auto corner_row = [&](uint32_t y) {
      std::vector<float> row;
      row.reserve(size.x + 1);
      for (uint32_t x = 0; x <= size.x; ++x) {
        row.push_back(at(static_cast<float>(x), static_cast<float>(y)));
      }
      return row;
    };
    weights_.resize(static_cast<size_t>(cells.x) * cells.y);
    double total = 0;
    std::vector<float> above = corner_row(0);
    for (uint32_t y = 0; y < size.y; ++y) {
      std::vector<float> below = corner_row(y + 1);
      float* const row = weights_.data() + static_cast<size_t>(y / parts) * cells.x;
      for (uint32_t x = 0; x < size.x; ++x) {
        const auto [min_flux, max_flux] =
            std::minmax({above[x], above[x + 1], below[x], below[x + 1]});
        float weight = 0.25f * (above[x] + above[x + 1] + below[x] + below[x + 1]);
        if (max_flux > 2 * min_flux) {
          weight = 0.5f * (weight + at(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f));
        }
        row[x / parts] += weight;
        total += static_cast<double>(weight);
      }
      above.swap(below);
    }
    // Every cell gets a minimum weight: there may be light between the evaluated points.
    const double count = static_cast<double>(weights_.size());
    mean_ = static_cast<float>(total / (static_cast<double>(size.x) * size.y));
    const auto floor = static_cast<float>(kFloor * total / count);
    for (float& weight : weights_) weight += floor;
    grid_ = GridDistribution(cells.x, cells.y, weights_);
    if (grid_.total() > 0) density_scale_ = count / grid_.total();
  }

  template <class F>
  struct SampleOf {
    wide::formulas::Vec2Of<F> uv;
    F pdf;  ///< per area of the unit square; never 0
  };
  using Sample = SampleOf<float>;
  /// Mean of the evaluated flux per area of the square.
  float mean() const { return mean_; }
  bool is_black() const { return !(grid_.total() > 0); }
  /// Returns nullopt if the flux is 0 everywhere.
  std::optional<Sample> sample(const Vec2& u) const {
    if (is_black()) return std::nullopt;
    const GridDistribution::Cell cell = grid_.sample(u);
    return in_cell<float>(static_cast<int32_t>(cell.column), static_cast<int32_t>(cell.row),
                          cell.u);
  }
  /// Requires that the flux isn't 0 everywhere.
  SampleOf<wide::Float> sample(wide::Vec2 u) const {
    const wide::GridCell cell = wide::sample_grid(grid_.tables(), u);
    return in_cell<wide::Float>(cell.column, cell.row, cell.u);
  }

  /// Density of sample() at a point of the unit square.
  template <class V2>
  wide::formulas::NumberOf<V2> pdf(const V2& uv) const {
    using namespace wide::formulas;
    using F = NumberOf<V2>;
    if (is_black()) return F(0.f);
    const auto index = [](const F& x, uint32_t count) {
      const auto cells = static_cast<float>(count);
      return to_int(min(max(F(0.f), x * cells), F(cells - 1.f)));
    };
    const F weight = gather(weights_.data(), index(uv.y, cells_.y) * static_cast<int32_t>(cells_.x) +
                                                 index(uv.x, cells_.x));
    return to_float(to_double(weight) * density_scale_);
  }

 private:
  template <class F>
  SampleOf<F> in_cell(wide::formulas::IntOf<F> column, wide::formulas::IntOf<F> row,
                      const wide::formulas::Vec2Of<F>& u) const {
    using namespace wide::formulas;
    const F weight = gather(weights_.data(), row * static_cast<int32_t>(cells_.x) + column);
    return {Vec2Of<F>(to_float(column) + u.x, to_float(row) + u.y) / Vec2Of<F>(Vec2(cells_)),
            to_float(to_double(weight) * density_scale_)};
  }

  /// Fraction of the mean flux that is added to every cell.
  static constexpr double kFloor = 1e-3;

  glm::uvec2 cells_;
  std::vector<float> weights_;
  GridDistribution grid_;
  double density_scale_ = 0;
  float mean_ = 0;
};

/// FluxGrid that is built when it is first needed. Thread-safe.
class LazyFluxGrid {
 public:
  /// make() returns the FluxGrid. It is only called once.
  template <class Make>
  const FluxGrid& get(const Make& make) const {
    std::call_once(is_made_, [&] { grid_.emplace(make()); });
    return *grid_;
  }

 private:
  mutable std::once_flag is_made_;
  mutable std::optional<FluxGrid> grid_;
};

}  // namespace kinome
