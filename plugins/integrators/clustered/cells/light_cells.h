#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "clustered/cells/cell_blocks.h"
#include "kinome/color.h"
#include "kinome/environment_grid.h"
#include "kinome/math.h"

namespace kinome {

class ClusteredLight;
class Emitter;
class QuadImportance;
class Scheduler;
struct GridIntegrals;

/// A direction of a cell's light, drawn with `density` per solid angle within the cell.
struct CellPoint {
  Vec3 d{0, 1, 0};  ///< unit, world space
  float density = 0;
  Rgb weight{0.f};  ///< radiance / density
  uint32_t cell = 0;
};

/// Points of all cells, drawn together.
struct CellPoints {
  std::vector<CellPoint> points;  ///< sorted by cell, within each cell along a Hilbert curve
  std::vector<uint32_t> first;    ///< first point of each cell; one more entry than cells
  /// Returns the point of a cell that u in [0, 1) selects.
  const CellPoint& pick(uint32_t cell, float u) const {
    const uint32_t begin = first[cell], count = first[cell + 1] - begin;
    return points[begin + static_cast<uint32_t>(u * static_cast<float>(count))];
  }
  /// Integral of radiance x direction over each cell [channel x 3 + axis]; see vector_flux().
  std::array<std::vector<float>, 9> vector_flux;
};

/// Cells of an environment's light: rectangles of an EnvironmentGrid, small where light varies, in
/// the order of a Hilbert curve over the sphere. Their stored integrals allow estimates of their
/// light without rays. Product sampling needs no other data of an environment.
///
/// Arrays have padded_size() values; the padding is cells without light. Immutable; thread-safe.
class DistantCells {
 public:
  /// Arrays are padded to a multiple of this value, for all instruction sets.
  static constexpr uint32_t kPadding = 16;

  /// Makes no cells, for scenes without an environment.
  DistantCells() = default;
  /// Divides the environment `emitter` into at most `count` cells, or more if needed so that none
  /// is wider than an eighth of a turn. A cell has negative light if the environment does.
  /// Densities are never 0 where there is light.
  DistantCells(const Emitter& emitter, const EnvironmentGrid& grid, uint32_t count,
               const Scheduler& scheduler);

  uint32_t size() const { return size_; }  ///< 0: the environment is black
  uint32_t padded_size() const { return static_cast<uint32_t>(flux_.size()); }

  /// Importance of each cell: integral of |radiance| (mean of the channels), with a minimum.
  const std::vector<float>& flux() const { return flux_; }
  /// Integral of radiance x direction over each cell, world space [channel x 3 + axis]. Only if
  /// has_exact_flux(); otherwise use CellPoints::vector_flux.
  const std::array<std::vector<float>, 9>& vector_flux() const { return vector_flux_; }
  bool has_exact_flux() const { return grid_.smooth_quads || grid_.bilinear_quads; }
  /// The same integral for the radiance of flux(), which has a single channel.
  const std::array<std::vector<float>, 3>& importance_flux() const { return importance_flux_; }
  /// axis(): unit mean direction of each cell, world space. radius(): half angle of a cone around
  /// it that contains the cell [rad].
  const std::array<std::vector<float>, 3>& axis() const { return axis_; }
  const std::vector<float>& radius() const { return radius_; }
  /// sin phi0, cos phi0, sin phi1, cos phi1, cos theta0, sin theta0, cos theta1, sin theta1 of each
  /// cell's rectangle in local space, for exact tests against a horizon.
  const std::array<std::vector<float>, 8>& edges() const { return edges_; }
  const CellBlocks& blocks() const { return blocks_; }
  Vec3 to_local(const Vec3& d) const { return d * grid_.to_world; }

  /// Draws about `count` points. Each cell gets a power of two of them, at least four. They are
  /// Owen-scrambled Sobol points, randomised by `seed`. A uniformly chosen point of a cell is
  /// distributed by the cell's density.
  CellPoints draw_points(uint32_t count, uint64_t seed, const Scheduler& scheduler) const;
  /// The same on the calling thread.
  CellPoints draw_points(uint32_t count, uint64_t seed) const;

  /// Arguments of look_up(): unit directions, world space; for each, the cell that contains it, the
  /// density of the cell's points there, per solid angle, and the radiance. Arrays must have a size
  /// of at least `count`, rounded up to a multiple of kPadding.
  struct Lookup {
    const float *dx, *dy, *dz;
    uint32_t* cell;
    float* density;
    Rgb* radiance;
  };
  void look_up(const Lookup& directions, size_t count) const;

 private:
  struct Rectangle {
    int x0, y0, x1, y1;
  };
  double tabulate(const Scheduler& scheduler);
  void tabulate_row(int row, float* importance) const;
  void tabulate_band(int y0, int y1);
  struct Candidate;
  double urgency(const Candidate& c) const;
  std::pair<Candidate, Candidate> halves(const Candidate& c) const;
  int max_width() const;
  void divide(uint32_t count);
  void describe(uint32_t cell, const GridIntegrals& integrals);
  void set_extent(uint32_t cell, const Vec3& centre);
  void add_smooth_flux(const Rectangle& r, double flux[9]) const;
  void add_bilinear_flux(const Rectangle& r, const GridIntegrals& integrals, double flux[9]) const;
  CellPoints count_points(uint32_t count) const;
  void draw_points_of(uint32_t cell, uint64_t seed, CellPoints& out) const;
  void draw_cell(uint32_t cell, uint64_t seed, std::span<CellPoint> points) const;
  Vec3 direction(double column, double row) const;
  /// The four Gauss points of each quad in columns x0 to x1 of a row, with the radiance there.
  struct GaussPoints {
    std::vector<Vec2> places;
    std::vector<Vec3> directions;
    std::vector<Rgb> radiance;
    /// Weights of the upper and of the lower two points; a quad's solid angle is twice their sum.
    double weights[2];
  };
  void find_gauss_points(int row, int x0, int x1, GaussPoints& points) const;
  /// Calls ClusteredLight::eval_grid_batch. `places` are positions in grid_; they are converted to
  /// the emitter's grid.
  bool eval_grid(std::span<Vec2> places, std::span<Rgb> radiance) const;
  /// Corners of quads on the upper edge of a row, columns x0 to x1.
  struct Nodes {
    std::vector<Vec2> places;
    std::vector<Rgb> radiance;
  };
  void find_nodes(int row, int x0, int x1, Nodes& nodes) const;
  float quad_solid_angle(int row) const;
  const Emitter* emitter_ = nullptr;
  const ClusteredLight* hooks_ = nullptr;  ///< functions of emitter_; may be nullptr
  EnvironmentGrid grid_;
  int columns_parts_ = 1;  ///< columns of grid_ per column of the emitter's grid
  int rows_parts_ = 1;
  uint32_t size_ = 0;
  std::shared_ptr<QuadImportance> importance_;         ///< per solid angle
  std::vector<double> column_sines_, column_cosines_;  ///< at each quad's two Gauss points
  std::vector<double> row_cosines_;                    ///< cos theta of each row's upper edge
  std::vector<Rectangle> rectangles_;                  ///< rectangle of each cell
  std::unique_ptr<uint16_t[]> cell_of_quad_;
  std::vector<float> inverse_flux_;
  std::vector<float> flux_;
  std::array<std::vector<float>, 9> vector_flux_;
  std::array<std::vector<float>, 3> importance_flux_;
  std::array<std::vector<float>, 3> axis_;
  std::vector<float> radius_;
  std::array<std::vector<float>, 8> edges_;
  CellBlocks blocks_;
};

/// Maximum number of cells. VisibilityRecord stores indices of these and of the cells of local
/// light in 16 bits.
inline constexpr uint32_t kMaxCells = 1u << 15;

}  // namespace kinome
