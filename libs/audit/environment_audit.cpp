#include "audit/environment_audit.h"

#include <numbers>

#include "kinome/clustered_light.h"
#include "audit/audit_words.h"
#include "audit/rounding.h"

namespace kinome {
namespace {

ColorRange radiance_around(const Emitter& emitter, const Vec3& d) {
  ColorRange range;
  for (const Vec3& near : neighbours(d)) range.add(emitter.eval_environment(near));
  return range;
}

/// Position in the grid.
struct GridPosition {
  int column, row;  ///< quad
  double s, t;      ///< position in the quad, in [0, 1]
  GridPosition(const EnvironmentGrid& grid, const Vec2& u) {
    const double x = static_cast<double>(u.x) * grid.columns;
    const double y = static_cast<double>(u.y) * grid.rows;
    column = std::min(static_cast<int>(x), grid.columns - 1);
    row = std::min(static_cast<int>(y), grid.rows - 1);
    s = x - column;
    t = y - row;
  }
};

/// Checks eval_grid_batch() at a position, and eval_grid_corners() at two corners of its quad.
const char* layout_contradiction(const Emitter& emitter, const EnvironmentGrid& grid,
                                 const GridPosition& at) {
  const Vec2 place(static_cast<float>(at.column + at.s), static_cast<float>(at.row + at.t));
  const Vec3 d = grid_direction(grid, static_cast<double>(place.x), static_cast<double>(place.y));
  Rgb radiance(0.f);
  const ClusteredLight* const hooks = clustered_light(emitter);
  if (!hooks) return nullptr;
  if (hooks->eval_grid_batch({&place, 1}, {&radiance, 1}) &&
      !radiance_around(emitter, d).agrees_with(radiance)) {
    return audit_words::kGrid;
  }
  // At a pole, all columns have the same direction.
  if (at.row == 0) return nullptr;
  std::array<Rgb, 2> corners{};
  if (!hooks->eval_grid_corners(at.row, at.column, corners)) return nullptr;
  for (int i = 0; i < 2; ++i) {
    const Vec3 corner = grid_direction(grid, at.column + i, at.row);
    if (!radiance_around(emitter, corner).agrees_with(corners[i])) return audit_words::kGrid;
  }
  return nullptr;
}

const char* bilinear_contradiction(const Emitter& emitter, const EnvironmentGrid& grid,
                                   const GridPosition& at) {
  if (at.row == 0 || at.row + 1 == grid.rows) return nullptr;  // two corners are a pole
  ColorRange interpolated;
  for (int i = 0; i < 4; ++i) {
    const int x = i & 1, y = i >> 1;
    const double weight = (x == 1 ? at.s : 1 - at.s) * (y == 1 ? at.t : 1 - at.t);
    const Vec3 corner = grid_direction(grid, at.column + x, at.row + y);
    interpolated.add_weighted(radiance_around(emitter, corner), weight);
  }
  const Vec3 d = grid_direction(grid, at.column + at.s, at.row + at.t);
  return radiance_around(emitter, d).agrees_with(interpolated) ? nullptr : audit_words::kBilinear;
}

/// Integrates the radiance of a quad with kNodes x kNodes Gauss points. The result is in arbitrary
/// units.
template <size_t kNodes>
double quad_flux(const Emitter& emitter, const EnvironmentGrid& grid, int column, int row,
                 const std::array<double, kNodes>& nodes,
                 const std::array<double, kNodes>& weights) {
  double sum = 0;
  for (size_t j = 0; j < kNodes; ++j) {
    const double sine = std::sin((row + nodes[j]) * std::numbers::pi / grid.rows);
    for (size_t i = 0; i < kNodes; ++i) {
      const Rgb radiance =
          emitter.eval_environment(grid_direction(grid, column + nodes[i], row + nodes[j]));
      const double mean = (double{radiance.x} + double{radiance.y} + double{radiance.z}) / 3;
      sum += weights[i] * weights[j] * sine * mean;
    }
  }
  return sum;
}

/// Compares quadrature with 4 points, which integrators use, and with 16 points, for the quad of a
/// sampled direction.
const char* smooth_contradiction(const Emitter& emitter, EnvironmentGrid grid, const Vec2& u) {
  const auto sample = emitter.sample_direct(Vec3(0.f), u);
  if (!sample || !(sample->pdf > 0)) return nullptr;
  const GridParts parts = parts_of(grid);
  grid.columns *= parts.columns;
  grid.rows *= parts.rows;
  grid.first_column *= static_cast<float>(parts.columns);
  const Vec3 local = sample->d * grid.to_world;
  const double turn = std::atan2(static_cast<double>(local.x), -static_cast<double>(local.z)) /
                      (2 * std::numbers::pi);
  const double share =
      std::acos(std::clamp(static_cast<double>(local.y), -1., 1.)) / std::numbers::pi;
  const double x = turn * grid.columns - static_cast<double>(grid.first_column);
  const int column = static_cast<int>(std::floor(x));
  const int row = std::clamp(static_cast<int>(share * grid.rows), 0, grid.rows - 1);
  // Nodes and weights of Gauss quadrature: Abramowitz and Stegun, table 25.4, mapped to [0, 1].
  constexpr double a = 0.28867513459481288, b = 0.43056815579702629, c = 0.16999052179242813;
  constexpr double wb = 0.17392742256872693, wc = 0.32607257743127307;
  const double by_4 = quad_flux<2>(emitter, grid, column, row, {0.5 - a, 0.5 + a}, {0.5, 0.5});
  const double by_16 = quad_flux<4>(emitter, grid, column, row,
                                    {0.5 - b, 0.5 - c, 0.5 + c, 0.5 + b}, {wb, wc, wc, wb});
  constexpr double kMaxError = 0.05;
  return std::abs(by_4 - by_16) <= kMaxError * std::max(std::abs(by_4), std::abs(by_16))
             ? nullptr
             : audit_words::kSmooth;
}

}  // namespace

const char* environment_contradiction(const Emitter& emitter, const DirectSample& sample) {
  ColorRange radiance;
  ValueRange pdf;
  for (const Vec3& near : neighbours(sample.d)) {
    radiance.add(emitter.eval_environment(near));
    pdf.add(static_cast<double>(emitter.pdf_environment(near)));
  }
  if (!pdf.agrees_with(static_cast<double>(sample.pdf))) return audit_words::kEnvironmentPdf;
  if (!radiance.agrees_with(sample.radiance)) return audit_words::kEnvironmentRadiance;
  Rgb batch_radiance(0.f);
  float batch_pdf = 0;
  eval_environment(emitter, {&sample.d, 1}, {&batch_radiance, 1}, {&batch_pdf, 1});
  return radiance.agrees_with(batch_radiance) && pdf.agrees_with(static_cast<double>(batch_pdf))
             ? nullptr
             : audit_words::kEvalBatch;
}

const char* grid_contradiction(const Emitter& emitter, const EnvironmentGrid& grid,
                               const AuditPlace& place, uint64_t attempt) {
  if (grid.columns < 1 || grid.rows < 1) return audit_words::kGrid;
  const uint64_t u = first_number(attempt) + 50;
  const GridPosition at(grid, place.u2(u));
  if (const char* const fault = layout_contradiction(emitter, grid, at)) return fault;
  if (grid.bilinear_quads) return bilinear_contradiction(emitter, grid, at);
  return grid.smooth_quads ? smooth_contradiction(emitter, grid, place.u2(u + 2)) : nullptr;
}

}  // namespace kinome
