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
/// Directions are sampled with a density proportional to the *interpolated* absolute luminance. In
/// a patch of four texels, the density per solid angle is the bilinear interpolation of theirs
/// times (linear interpolation of sin theta between rows) / sin theta. This factor is within (pi /
/// H)² / 8 of 1, and allows sampling the patch by inverting polynomials. Thus density and radiance
/// are zero at the same points, and no texel leaks at the poles.
///
/// Immutable; thread-safe. Directions are unit vectors. Construction is in spherical_map.cpp,
/// evaluation and sampling in spherical_map_points.cpp.
class SphericalMap {
 public:
  /// Uses the first three channels of `image` (or its only one), which must be finite. With
  /// `compensate`, sampling favours radiance above the mean (Karlík et al. 2019).
  SphericalMap(const Image& image, float scale, bool compensate);

  int columns() const { return width_; }
  /// Number of stored rows, which is larger than the image's if the map was refined.
  int rows() const { return height_; }

  Rgb eval(const Vec3& d) const;
  /// Density of sample() per solid angle.
  float pdf(const Vec3& d) const;
  struct Sample {
    Vec3 d{0, 1, 0};
    Rgb radiance{0.f};
    float pdf = 0;
  };
  /// Returns nullopt if the map is black.
  std::optional<Sample> sample(const Vec2& u) const;

  /// Maximum number of an image's texels, because int32_t counts their floats. Refined images stay
  /// far below it, because readers accept at most 2^17 columns.
  static constexpr size_t kMaxTexels = size_t{1} << 28;

  /// Evaluate and sample blocks of directions in another space. to_local and to_world, rotations or
  /// reflections, map from and to that space. pdf may be nullptr; a sample with pdf 0 is invalid.
  void eval_columns(const glm::mat3& to_local, const Columns3& d, size_t count,
                    const Columns3& radiance, float* pdf) const;
  void sample_columns(const glm::mat3& to_world, const Columns2& u, size_t count,
                      const DirectBlock& out) const;

  /// Evaluates up to kBlock directions with the same bits as eval() and pdf(). Memory is prefetched
  /// while other directions are processed: the tables of a typical map exceed the caches.
  static constexpr size_t kBlock = 64;
  void eval_block(std::span<const Vec3> d, Rgb* radiance, float* pdf) const;
  /// Evaluates the radiance at up to kBlock points, in units of columns (0 is the centre of column
  /// 0) and rows.
  void eval_places(std::span<const Vec2> places, Rgb* radiance) const;
  /// Copies the radiance of a row's texels from column `first` on. Columns wrap around once.
  void copy_texels(int row, int first, std::span<Rgb> radiance) const;
  /// Returns the integral of the radiance over each cell, exact up to rounding.
  std::vector<Rgb> integrate(const SpherePartition& cells) const;

 private:
  struct Texel {
    Rgb radiance;
    float weight;  ///< target density of sampling, per solid angle
  };
  /// Position of a direction: the patch's upper left texel, its row, and coordinates in the patch.
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
  /// Samples points in `n` patches, or vectors of patches, at once, so that their iterations
  /// overlap.
  template <class F, size_t n>
  void draw(const wide::formulas::IntOf<F> (&row)[n], const wide::formulas::IntOf<F> (&column)[n],
            const wide::formulas::Vec2Of<F> (&u)[n], Drawn<F> (&drawn)[n]) const;
  template <class F>
  Drawn<F> finish_draw(wide::formulas::IntOf<F> row, wide::formulas::IntOf<F> column, F left, F right,
                       F u, F t) const;
  /// Interpolated sin theta divided by the exact one.
  template <class F>
  F sine_ratio(const Place<F>& at) const;
  /// Radiance, and the weight as the fourth component.
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
  int height_;                 ///< number of stored rows, at least kMinRows
  float row_angle_;            ///< step of theta between rows
  std::vector<Texel> texels_;  ///< a row's first texel is repeated at its end
  std::vector<float> sines_;   ///< sin theta of each row
  GridDistribution patches_;
};

}  // namespace kinome
