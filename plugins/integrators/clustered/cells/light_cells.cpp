#include "clustered/cells/light_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "clustered/cells/grid_integrals.h"
#include "clustered/cells/channel_mean.h"
#include "clustered/cells/quad_importance.h"
#include "kinome/clustered_light.h"
#include "kinome/scheduler.h"

namespace kinome {
namespace {

/// Gauss-Legendre nodes of order 2 in [0, 1].
constexpr double kGauss[2] = {0.5 - 0.28867513459481288, 0.5 + 0.28867513459481288};
/// Minimum importance as a share of the mean, so that directions keep a density where a photograph
/// is black or tabulated too coarsely.
constexpr double kFloor = 1e-3;
/// Importance of a quad of a probed grid, relative to that of its best neighbour.
constexpr float kShareOfNeighbour = 0.25f;
/// Number of rows of quads that are tabulated together.
constexpr int kBand = 16;

}  // namespace

DistantCells::DistantCells(const Emitter& emitter, const EnvironmentGrid& grid, uint32_t count,
                           const Scheduler& scheduler)
    : emitter_(&emitter), hooks_(clustered_light(emitter)), grid_(grid) {
  const GridParts parts = parts_of(grid_);
  columns_parts_ = parts.columns;
  rows_parts_ = parts.rows;
  grid_.columns *= columns_parts_;
  grid_.rows *= rows_parts_;
  grid_.first_column *= static_cast<float>(columns_parts_);
  if (!(tabulate(scheduler) > 0)) return;
  divide(std::clamp(count, 1u, kMaxCells));
  const size_t padded = (size_ + kPadding - 1) / kPadding * kPadding;
  const auto resize = [&](std::vector<float>& v) { v.assign(padded, 0.f); };
  resize(flux_);
  resize(radius_);
  resize(inverse_flux_);
  for (auto& v : vector_flux_) resize(v);
  for (auto& v : importance_flux_) resize(v);
  for (auto& v : axis_) resize(v);
  for (auto& v : edges_) resize(v);
  const GridIntegrals integrals(grid_);
  scheduler.parallel_for(size_, [&](size_t i) { describe(static_cast<uint32_t>(i), integrals); });
  blocks_ = CellBlocks(*this);
}

Vec3 DistantCells::direction(double column, double row) const {
  return grid_direction(grid_, column, row);
}

float DistantCells::quad_solid_angle(int row) const {
  return static_cast<float>((row_cosines_[row] - row_cosines_[row + 1]) * 2 * std::numbers::pi /
                            grid_.columns);
}

bool DistantCells::eval_grid(std::span<Vec2> places, std::span<Rgb> radiance) const {
  if (columns_parts_ > 1 || rows_parts_ > 1) {
    const Vec2 parts(static_cast<float>(columns_parts_), static_cast<float>(rows_parts_));
    for (Vec2& place : places) place /= parts;
  }
  return hooks_ && hooks_->eval_grid_batch(places, radiance);
}

void DistantCells::find_gauss_points(int row, int x0, int x1, GaussPoints& points) const {
  const size_t count = static_cast<size_t>(x1 - x0) * 4;
  points.places.resize(count);
  points.directions.resize(count);
  points.radiance.resize(count);
  double sines[2];
  for (int g = 0; g < 2; ++g) {
    const double theta = (row + kGauss[g]) * std::numbers::pi / grid_.rows;
    const double cosine = std::cos(theta);
    sines[g] = std::sin(theta);
    for (int i = 2 * x0; i < 2 * x1; ++i) {
      const size_t k = static_cast<size_t>(i / 2 - x0) * 4 + 2 * g + i % 2;
      const Vec3 local(static_cast<float>(sines[g] * column_sines_[i]), static_cast<float>(cosine),
                       static_cast<float>(-sines[g] * column_cosines_[i]));
      points.directions[k] = grid_.to_world * local;
      points.places[k] = {static_cast<float>(i / 2 + kGauss[i % 2]),
                          static_cast<float>(row + kGauss[g])};
    }
  }
  const double scale = 0.5 * quad_solid_angle(row) / (sines[0] + sines[1]);
  for (int g = 0; g < 2; ++g) points.weights[g] = sines[g] * scale;
  if (!eval_grid(points.places, points.radiance)) {
    eval_environment(*emitter_, points.directions, points.radiance);
  }
}

void DistantCells::find_nodes(int row, int x0, int x1, Nodes& nodes) const {
  const size_t count = static_cast<size_t>(x1 - x0) + 1;
  nodes.radiance.resize(count);
  if (hooks_ && columns_parts_ == 1 && rows_parts_ == 1 &&
      hooks_->eval_grid_corners(row, x0, nodes.radiance)) {
    return;
  }
  nodes.places.resize(count);
  for (size_t i = 0; i < count; ++i) {
    nodes.places[i] = {static_cast<float>(x0 + static_cast<int>(i)), static_cast<float>(row)};
  }
  if (eval_grid(nodes.places, nodes.radiance)) return;
  std::vector<Vec3> directions;
  for (size_t i = 0; i < count; ++i) {
    directions.push_back(direction(static_cast<double>(x0) + static_cast<double>(i), row));
  }
  eval_environment(*emitter_, directions, nodes.radiance);
}

/// Tabulates the importance of a row. Densities needn't be exact: the centre of a smooth quad is
/// enough.
void DistantCells::tabulate_row(int row, float* importance) const {
  thread_local GaussPoints points;
  if (grid_.smooth_quads) {
    points.places.resize(grid_.columns);
    points.radiance.resize(grid_.columns);
    for (int x = 0; x < grid_.columns; ++x) {
      points.places[x] = {static_cast<float>(x) + 0.5f, static_cast<float>(row) + 0.5f};
    }
    if (!eval_grid(points.places, points.radiance)) {
      find_gauss_points(row, 0, grid_.columns, points);
    }
  } else {
    find_gauss_points(row, 0, grid_.columns, points);
  }
  const size_t per_quad = points.radiance.size() / grid_.columns;
  for (int x = 0; x < grid_.columns; ++x) {
    float sum = 0;
    for (size_t g = 0; g < per_quad; ++g) {
      sum += std::abs(mean_of(points.radiance[x * per_quad + g]));
    }
    importance[x] = sum / static_cast<float>(per_quad);
  }
}

/// Tabulates the importance of bilinear quads in rows [y0, y1). The value at the centre of a quad
/// is the mean of its corners.
void DistantCells::tabulate_band(int y0, int y1) {
  thread_local Nodes nodes;
  thread_local std::vector<float> upper, lower;
  for (int y = y0; y <= y1; ++y) {
    find_nodes(y, 0, grid_.columns, nodes);
    lower.resize(nodes.radiance.size());
    for (size_t i = 0; i < lower.size(); ++i) lower[i] = mean_of(nodes.radiance[i]);
    if (y > y0) {
      float* const importance = importance_->row(y - 1);
      for (int x = 0; x < grid_.columns; ++x) {
        importance[x] = 0.25f * std::abs(upper[x] + upper[x + 1] + lower[x] + lower[x + 1]);
      }
    }
    std::swap(upper, lower);
  }
}

/// Tabulates the importance of all quads; returns its integral over the sphere.
double DistantCells::tabulate(const Scheduler& scheduler) {
  const int columns = grid_.columns, rows = grid_.rows;
  importance_ = std::make_shared<QuadImportance>(columns, rows);
  row_cosines_.resize(rows + 1);
  for (int y = 0; y <= rows; ++y) row_cosines_[y] = std::cos(std::numbers::pi * y / rows);
  for (int i = 0; i < 2 * columns; ++i) {
    const double column = i / 2 + kGauss[i % 2] + grid_.first_column;
    const double phi = column * 2 * std::numbers::pi / columns;
    column_sines_.push_back(std::sin(phi));
    column_cosines_.push_back(std::cos(phi));
  }
  std::vector<double> row_means(rows);
  scheduler.parallel_for((rows + kBand - 1) / kBand, [&](size_t band) {
    const int y0 = static_cast<int>(band) * kBand, y1 = std::min(y0 + kBand, rows);
    if (grid_.bilinear_quads) tabulate_band(y0, y1);
    for (int y = y0; y < y1; ++y) {
      float* const importance = importance_->row(y);
      if (!grid_.bilinear_quads) tabulate_row(y, importance);
      double sum = 0;
      for (int x = 0; x < columns; ++x) sum += importance[x];
      row_means[y] = sum * quad_solid_angle(y);
    }
  });
  if (grid_.is_probed) {
    importance_->spread(kShareOfNeighbour);
    for (int y = 0; y < rows; ++y) {
      const float* const importance = importance_->row(y);
      row_means[y] = std::accumulate(importance, importance + columns, 0.) * quad_solid_angle(y);
    }
  }
  double total = 0;
  for (const double mean : row_means) total += mean;
  const auto least = static_cast<float>(kFloor * total / (4 * std::numbers::pi));
  scheduler.parallel_for(rows, [&](size_t y) { importance_->sum_row(static_cast<int>(y), least); });
  return total;
}

void DistantCells::add_smooth_flux(const Rectangle& r, double flux[9]) const {
  thread_local GaussPoints tls_points;
  GaussPoints& points = tls_points;
  for (int y = r.y0; y < r.y1; ++y) {
    find_gauss_points(y, r.x0, r.x1, points);
    for (size_t i = 0; i < points.directions.size(); ++i) {
      const double w = points.weights[i / 2 % 2];
      for (int k = 0; k < 9; ++k)
        flux[k] += points.directions[i][k % 3] * w * points.radiance[i][k / 3];
    }
  }
}

/// Adds the light of each node: its radiance times a linear interpolation along columns and one
/// along rows.
void DistantCells::add_bilinear_flux(const Rectangle& r, const GridIntegrals& integrals,
                                     double flux[9]) const {
  thread_local Nodes tls_nodes;
  thread_local std::vector<glm::dvec3> tls_weights;
  Nodes& nodes = tls_nodes;
  std::vector<glm::dvec3>& weights = tls_weights;
  weights.clear();
  for (int x = r.x0; x <= r.x1; ++x) {
    weights.emplace_back(integrals.sine.at_node(x, r.x0, r.x1),
                         integrals.width.at_node(x, r.x0, r.x1),
                         -integrals.cosine.at_node(x, r.x0, r.x1));
  }
  const glm::dmat3 to_world(grid_.to_world);
  glm::dvec3 local[3] = {};
  for (int y = r.y0; y <= r.y1; ++y) {
    find_nodes(y, r.x0, r.x1, nodes);
    glm::dvec3 red(0.), green(0.), blue(0.);
    for (size_t i = 0; i < weights.size(); ++i) {
      const glm::dvec3 radiance(nodes.radiance[i]);
      red += radiance.x * weights[i];
      green += radiance.y * weights[i];
      blue += radiance.z * weights[i];
    }
    const double across = integrals.sine_squared.at_node(y, r.y0, r.y1);
    const glm::dvec3 along(across, integrals.product.at_node(y, r.y0, r.y1), across);
    local[0] += along * red;
    local[1] += along * green;
    local[2] += along * blue;
  }
  for (int c = 0; c < 3; ++c) {
    const glm::dvec3 world = to_world * local[c];
    for (int axis = 0; axis < 3; ++axis) flux[c * 3 + axis] += world[axis];
  }
}

void DistantCells::describe(uint32_t cell, const GridIntegrals& integrals) {
  thread_local std::vector<glm::dvec3> tls_columns;
  std::vector<glm::dvec3>& columns = tls_columns;
  const Rectangle& r = rectangles_[cell];
  columns.clear();
  glm::dvec3 all_columns(0.);
  for (int x = r.x0; x < r.x1; ++x) {
    all_columns += columns.emplace_back(integrals.sine.whole(x), integrals.width.whole(x),
                                        -integrals.cosine.whole(x));
  }
  double sum = 0;
  glm::dvec3 mean_local(0.), importance_local(0.);
  for (int y = r.y0; y < r.y1; ++y) {
    const float* const importance = importance_->row(y) + r.x0;
    glm::dvec3 row_sum(0.);
    for (size_t i = 0; i < columns.size(); ++i) {
      row_sum += static_cast<double>(importance[i]) * columns[i];
    }
    const double across = integrals.sine_squared.whole(y);
    const glm::dvec3 along(across, integrals.product.whole(y), across);
    mean_local += along * all_columns;
    importance_local += along * row_sum;
    sum += importance_->sum(y, r.x0, r.x1).values * quad_solid_angle(y);
    uint16_t* const cells = &cell_of_quad_[static_cast<size_t>(y) * grid_.columns];
    std::fill(cells + r.x0, cells + r.x1, static_cast<uint16_t>(cell));
  }
  flux_[cell] = static_cast<float>(sum);
  inverse_flux_[cell] = static_cast<float>(1 / sum);
  double flux[9] = {};
  if (grid_.bilinear_quads) {
    add_bilinear_flux(r, integrals, flux);
  } else if (grid_.smooth_quads) {
    add_smooth_flux(r, flux);
  }
  const glm::dmat3 to_world(grid_.to_world);
  const glm::dvec3 mean = to_world * mean_local, importance = to_world * importance_local;
  const double length = std::sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]);
  const Vec3 centre(static_cast<float>(mean[0] / length), static_cast<float>(mean[1] / length),
                    static_cast<float>(mean[2] / length));
  for (int axis = 0; axis < 3; ++axis) {
    axis_[axis][cell] = centre[axis];
    importance_flux_[axis][cell] = static_cast<float>(importance[axis]);
    for (int c = 0; c < 3; ++c) {
      vector_flux_[c * 3 + axis][cell] = static_cast<float>(flux[c * 3 + axis]);
    }
  }
  set_extent(cell, centre);
}

/// Sets the cone around `centre`, and the edges of a cell.
void DistantCells::set_extent(uint32_t cell, const Vec3& centre) {
  const Rectangle& r = rectangles_[cell];
  float min_cosine = 1;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; j <= 4; ++j) {
      const Vec3 d = direction(r.x0 + (r.x1 - r.x0) * i / 4., r.y0 + (r.y1 - r.y0) * j / 4.);
      min_cosine = std::min(min_cosine, glm::dot(centre, d));
    }
  }
  radius_[cell] = std::acos(std::clamp(min_cosine, -1.f, 1.f));
  const double turn = 2 * std::numbers::pi / grid_.columns;
  const double phi[2] = {(r.x0 + grid_.first_column) * turn, (r.x1 + grid_.first_column) * turn};
  const double theta[2] = {r.y0 * std::numbers::pi / grid_.rows,
                           r.y1 * std::numbers::pi / grid_.rows};
  for (int k = 0; k < 2; ++k) {
    edges_[2 * k][cell] = static_cast<float>(std::sin(phi[k]));
    edges_[2 * k + 1][cell] = static_cast<float>(std::cos(phi[k]));
    edges_[4 + 2 * k][cell] = static_cast<float>(std::cos(theta[k]));
    edges_[5 + 2 * k][cell] = static_cast<float>(std::sin(theta[k]));
  }
}

}  // namespace kinome
