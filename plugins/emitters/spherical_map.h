#pragma once

#include <optional>
#include <span>
#include <vector>

#include "kinome/blocks.h"
#include "kinome/color.h"
#include "kinome/distribution.h"
#include "kinome/image.h"
#include "kinome/light_points.h"
#include "kinome/sphere_partition.h"
#include "kinome/wide/vectors.h"

namespace kinome {

/// Radiance over directions as a latitude-longitude image, interpolated bilinearly in (phi, theta).
///
/// d = (sin phi sin theta, cos theta, -cos phi sin theta); column j of W lies at
/// phi = 2 pi (j + 1/2) / W, periodic, and row i of H at theta = i pi / (H - 1).
///
/// Directions are drawn with a density that is proportional to the *interpolated* absolute
/// luminance: within a patch of four texels it is the bilinear interpolation of theirs, per solid
/// angle, but for a factor (linear interpolation of sin theta between rows) / sin theta, which
/// stays within (pi / H)² / 8 of 1 and lets the patch be sampled by inverting polynomials. Density
/// and radiance thus vanish at the same places, and no texel leaks at the poles.
/// Immutable; thread-safe. Directions are unit vectors. Made in spherical_map.cpp; its points, one
/// and many at a time, are in spherical_map_points.cpp.
class SphericalMap {
 public:
  /// The first three channels of `image` (or its one), all finite. `compensate`: Karlík et al.
  /// 2019; sampling then favours what is brighter than the mean.
  SphericalMap(const Image& image, float scale, bool compensate);

  int columns() const { return width_; }
  /// Of the rows kept: a map of few is refined.
  int rows() const { return height_; }

  Rgb eval(const Vec3& d) const;
  /// Per solid angle.
  float pdf(const Vec3& d) const;
  struct Sample {
    Vec3 d{0, 1, 0};
    Rgb radiance{0.f};
    float pdf = 0;
  };
  /// nullopt for a black map.
  std::optional<Sample> sample(const Vec2& u) const;

  /// Of an image: floats of texels are counted in int32_t. An image of few rows, which is refined
  /// to more, stays far below: no reader takes more than 2^17 columns.
  static constexpr size_t kMostTexels = size_t{1} << 28;

  /// By columns, for directions in the space that to_local or to_world, a rotation or reflection,
  /// leads from or to. pdf may be nullptr; one of 0 stands for nullopt.
  void eval_columns(const glm::mat3& to_local, const Columns3& d, size_t count,
                    const Columns3& radiance, float* pdf) const;
  void sample_columns(const glm::mat3& to_world, const Columns2& u, size_t count,
                      const DirectBlock& out) const;

  /// The same for up to kBlock at a time, equal to the last bit. What one needs from memory is
  /// fetched while others are worked on: the tables of a usual map exceed the caches.
  static constexpr size_t kBlock = 64;
  void eval_block(std::span<const Vec3> d, Rgb* radiance, float* pdf) const;
  /// Radiance at up to kBlock places, in units of columns from column 0's centre on, and of rows.
  void eval_places(std::span<const Vec2> places, Rgb* radiance) const;
  /// Radiance of the texels of a row from column `first` on; after the last one comes the first.
  void copy_texels(int row, int first, std::span<Rgb> radiance) const;
  /// The radiance integrated over each cell, exactly (up to rounding).
  std::vector<Rgb> integrate(const SpherePartition& cells) const;

 private:
  /// Weight: the density per solid angle that sampling aims at.
  struct Texel {
    Rgb radiance;
    float weight;
  };
  /// Where a direction lies: the patch's upper left texel, its row, and coordinates in the patch.
  template <class F>
  struct Place {
    wide::formulas::IntOf<F> texel;
    wide::formulas::IntOf<F> row;
    F s;
    F t;
    F sin_theta;
  };
  template <class F>
  struct Drawn {
    Place<F> place;
    wide::formulas::VecOf<F> d;
    F pdf;
  };
  void fill(const Image& image, float scale);
  void set_weights(bool compensate);
  template <class F>
  Place<F> locate(const wide::formulas::VecOf<F>& d) const;
  /// Points in `n` patches, or vectors of patches, at once: their iterations then don't wait for
  /// one another.
  template <class F, size_t n>
  void draw(const wide::formulas::IntOf<F> (&row)[n], const wide::formulas::IntOf<F> (&column)[n],
            const wide::formulas::Vec2Of<F> (&u)[n], Drawn<F> (&drawn)[n]) const;
  template <class F>
  Drawn<F> finish_draw(wide::formulas::IntOf<F> row, wide::formulas::IntOf<F> column, F left, F right,
                       F u, F t) const;
  /// Interpolated sin theta, relative to the true one.
  template <class F>
  F sine_ratio(const Place<F>& at) const;
  /// Radiance and, as the fourth, weight.
  using Float4 = float __attribute__((vector_size(16)));
  Float4 interpolate(size_t texel, float s, float t) const;
  struct Interpolated {
    wide::Rgb radiance;
    wide::Float weight;
  };
  Interpolated interpolate_lanes(const uint32_t* texel, const float* s, const float* t) const;
  void prefetch(uint32_t texel) const;
  Sample sample_patch(const GridDistribution::Cell& patch) const;
  const Texel* row(int i) const { return texels_.data() + static_cast<size_t>(i) * (width_ + 1); }
  void integrate_ring(double theta0, double theta1, std::vector<glm::vec4>& columns) const;

  int width_;
  int height_;                 ///< of the texels kept: at least kMinRows
  float row_angle_;            ///< theta from row to row
  std::vector<Texel> texels_;  ///< a row's first texel is repeated at its end
  std::vector<float> sines_;   ///< sin theta of each row
  GridDistribution patches_;
};

}  // namespace kinome
