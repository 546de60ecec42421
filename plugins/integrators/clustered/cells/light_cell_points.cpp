// Functions of DistantCells that are called while rendering: draw_points() and look_up().
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "clustered/cells/hilbert_points.h"
#include "clustered/cells/light_cells.h"
#include "clustered/cells/quad_importance.h"
#include "clustered/kernels/candidate_kernels.h"
#include "kinome/clustered_light.h"
#include "kinome/scheduler.h"
#include "kinome/sampler.h"

namespace kinome {

CellPoints DistantCells::draw_points(uint32_t count, uint64_t seed,
                                     const Scheduler& scheduler) const {
  CellPoints out = count_points(count);
  scheduler.parallel_for(
      size_, [&](size_t i) { draw_points_of(static_cast<uint32_t>(i), seed, out); });
  return out;
}

CellPoints DistantCells::draw_points(uint32_t count, uint64_t seed) const {
  CellPoints out = count_points(count);
  for (uint32_t c = 0; c < size_; ++c) draw_points_of(c, seed, out);
  return out;
}

/// Returns uninitialised points, with the number of each cell.
CellPoints DistantCells::count_points(uint32_t count) const {
  double roots = 0;
  for (uint32_t c = 0; c < size_; ++c) roots += std::sqrt(static_cast<double>(flux_[c]));
  const uint32_t least = std::clamp(std::bit_floor(count / size_), 4u, 16u);
  CellPoints out;
  out.first.push_back(0);
  for (uint32_t c = 0; c < size_; ++c) {
    const double wanted =
        count * (0.5 / size_ + 0.5 * std::sqrt(static_cast<double>(flux_[c])) / roots);
    uint32_t points = least;
    while (points * std::numbers::sqrt2 < wanted && points < 1024) points *= 2;
    out.first.push_back(out.first.back() + points);
  }
  out.points.resize(out.first.back());
  for (auto& v : out.vector_flux) v.assign(padded_size(), 0.f);
  return out;
}

void DistantCells::draw_points_of(uint32_t cell, uint64_t seed, CellPoints& out) const {
  const std::span points(out.points.data() + out.first[cell],
                         out.first[cell + 1] - out.first[cell]);
  draw_cell(cell, hash_words(seed, cell), points);
  for (int k = 0; k < 9; ++k) {
    if (has_exact_flux()) {
      out.vector_flux[k][cell] = vector_flux_[k][cell];
      continue;
    }
    double flux = 0;
    for (const CellPoint& point : points) flux += point.weight[k / 3] * point.d[k % 3];
    out.vector_flux[k][cell] = static_cast<float>(flux / static_cast<double>(points.size()));
  }
}

void DistantCells::draw_cell(uint32_t cell, uint64_t seed, std::span<CellPoint> points) const {
  thread_local std::vector<double> cumulated;
  thread_local std::vector<Vec3> directions;
  thread_local std::vector<Rgb> radiance;
  const Rectangle& r = rectangles_[cell];
  const int height = r.y1 - r.y0;
  cumulated.assign(height + 1, 0.);
  for (int y = 0; y < height; ++y) {
    cumulated[y + 1] =
        cumulated[y] + importance_->sum(r.y0 + y, r.x0, r.x1).values * quad_solid_angle(r.y0 + y);
  }
  const double total = cumulated[height];
  const auto shares =
      HilbertPoints::get().power_of_two(static_cast<uint32_t>(std::countr_zero(points.size())));
  const auto shift_x = static_cast<uint32_t>(seed), shift_y = static_cast<uint32_t>(seed >> 32);
  directions.resize(points.size());
  radiance.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec2 u = shares[i].shifted(shift_x, shift_y);
    const double along = u.y * total;
    const auto above = std::upper_bound(cumulated.begin() + 1, cumulated.end() - 1, along);
    const auto y = static_cast<int>(above - cumulated.begin()) - 1;
    const double share_y =
        std::clamp((along - cumulated[y]) / (cumulated[y + 1] - cumulated[y]), 0., 0.9999999);
    const auto [x, share_x] = importance_->find(r.y0 + y, r.x0, r.x1, u.x);
    // Uniform in solid angle within the quad.
    const double upper = row_cosines_[r.y0 + y], lower = row_cosines_[r.y0 + y + 1];
    const double cosine = upper + (lower - upper) * share_y;
    const double sine = std::sqrt(std::max(0., 1 - cosine * cosine));
    const double phi = (x + share_x + grid_.first_column) * 2 * std::numbers::pi / grid_.columns;
    const Vec3 local(static_cast<float>(sine * std::sin(phi)), static_cast<float>(cosine),
                     static_cast<float>(-sine * std::cos(phi)));
    directions[i] = glm::normalize(grid_.to_world * local);
    points[i].cell = cell;
    points[i].d = directions[i];
    points[i].density = static_cast<float>(importance_->row(r.y0 + y)[x] / total);
  }
  eval_environment(*emitter_, directions, radiance);
  for (size_t i = 0; i < points.size(); ++i) points[i].weight = radiance[i] / points[i].density;
}

void DistantCells::look_up(const Lookup& to, size_t count) const {
  thread_local std::vector<Vec2> places;
  thread_local std::vector<uint32_t> quads;
  const size_t padded = (count + kPadding - 1) / kPadding * kPadding;
  if (places.size() < padded) {
    places.resize(padded);
    quads.resize(padded);
  }
  simd::SphereGrid grid{{}, grid_.columns, grid_.rows, grid_.first_column};
  for (int i = 0; i < 9; ++i) grid.to_local[i] = grid_.to_world[i / 3][i % 3];
  simd::find_places(grid, to.dx, to.dy, to.dz, padded, &places[0].x, quads.data());
  const QuadImportance& importance = *importance_;
  for (size_t i = 0; i < count; ++i) {
    __builtin_prefetch(&cell_of_quad_[quads[i]]);
    __builtin_prefetch(&importance[quads[i]]);
  }
  const bool has_radiance = eval_grid({places.data(), count}, {to.radiance, count});
  for (size_t i = 0; i < count; ++i) {
    to.cell[i] = cell_of_quad_[quads[i]];
    to.density[i] = importance[quads[i]] * inverse_flux_[to.cell[i]];
  }
  if (has_radiance) return;
  thread_local std::vector<Vec3> directions;
  directions.resize(count);
  for (size_t i = 0; i < count; ++i) directions[i] = {to.dx[i], to.dy[i], to.dz[i]};
  eval_environment(*emitter_, directions, {to.radiance, count});
}

}  // namespace kinome
