#pragma once

#include <optional>
#include <vector>

#include "kinome/distribution.h"

namespace kinome {

/// Points of the unit square by the flux of a light that leaves through them: constant in each cell
/// of a grid. Immutable; thread-safe.
class FluxGrid {
 public:
  /// flux(uv), in any unit and not negative, is looked up at `lookups` x `lookups` points of each
  /// cell.
  template <class Flux>
  FluxGrid(glm::uvec2 cells, uint32_t lookups, const Flux& flux) : cells_(cells) {
    weights_.reserve(static_cast<size_t>(cells.x) * cells.y);
    double total = 0;
    for (uint32_t row = 0; row < cells.y; ++row) {
      for (uint32_t column = 0; column < cells.x; ++column) {
        double sum = 0;
        for (uint32_t i = 0; i < lookups * lookups; ++i) {
          const Vec2 inside(static_cast<float>(i % lookups) + 0.5f,
                            static_cast<float>(i / lookups) + 0.5f);
          const Vec2 place = Vec2(column, row) + inside / static_cast<float>(lookups);
          sum += static_cast<double>(flux(place / Vec2(cells)));
        }
        weights_.push_back(static_cast<float>(sum / (lookups * lookups)));
        total += static_cast<double>(weights_.back());
      }
    }
    const double count = static_cast<double>(weights_.size());
    // No cell is left out: light may pass between the points that were looked up.
    const auto floor = static_cast<float>(kFloor * total / count);
    for (float& weight : weights_) weight += floor;
    grid_ = GridDistribution(cells.x, cells.y, weights_);
    if (grid_.total() > 0) density_scale_ = count / grid_.total();
  }

  struct Sample {
    Vec2 uv{0.f};
    float pdf = 0;  ///< per area of the unit square; never 0
  };
  /// nullopt where there is no light at all.
  std::optional<Sample> sample(const Vec2& u) const {
    if (!(grid_.total() > 0)) return std::nullopt;
    const GridDistribution::Cell cell = grid_.sample(u);
    const size_t index = static_cast<size_t>(cell.row) * cells_.x + cell.column;
    return Sample{(Vec2(cell.column, cell.row) + cell.u) / Vec2(cells_),
                  static_cast<float>(static_cast<double>(weights_[index]) * density_scale_)};
  }

 private:
  /// Share of the mean flux that every cell gets on top of its own.
  static constexpr double kFloor = 1e-3;

  glm::uvec2 cells_;
  std::vector<float> weights_;
  GridDistribution grid_;
  double density_scale_ = 0;
};

}  // namespace kinome
