#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "kinome/volume.h"
#include "kinome/wide/vectors.h"
#include "vol_file.h"

/// Look-up in grids of voxels. Voxel k covers [k, k + 1] / N along an axis with N voxels of the
/// unit cube, and its value is that of its centre.
namespace kinome {

enum class VoxelFilter { kTrilinear, kNearest };
enum class VoxelWrap { kClamp, kRepeat, kMirror };

class Voxels {
 public:
  /// `to_cube` transforms world space to the unit cube that the grid fills.
  Voxels(VoxelGrid grid, const Transform& to_cube, VoxelFilter filter, VoxelWrap wrap)
      : grid_(std::move(grid)), filter_(filter), wrap_(wrap), size_(grid_.size) {
    // In the space of indices, voxel k has its centre at k.
    const glm::dmat4 m(to_cube.matrix());
    for (int column = 0; column < 3; ++column) {
      to_index_[column] = Vec3(glm::dvec3(m[column]) * glm::dvec3(size_));
    }
    offset_ = Vec3(glm::dvec3(m[3]) * glm::dvec3(size_) - 0.5);
  }

  const VoxelGrid& grid() const { return grid_; }

  /// Evaluates the channels at p: calls out(channel, value).
  template <class F, class Out>
  void eval(const wide::VecOf<F>& p, const Out& out) const {
    using namespace wide::formulas;
    const wide::VecOf<F> at = to_index_ * p + wide::VecOf<F>(offset_);
    const auto channels = static_cast<int32_t>(grid_.channels);
    const float* const values = grid_.values.data();
    if (filter_ == VoxelFilter::kNearest) {
      using std::floor;
      const wide::IntOf<F> i = index(wrapped(floor(at.x + 0.5f), 0), wrapped(floor(at.y + 0.5f), 1),
                                     wrapped(floor(at.z + 0.5f), 2));
      for (int32_t c = 0; c < channels; ++c) out(c, gather(values + c, i));
      return;
    }
    const Axis<F> x = axis(at.x, 0), y = axis(at.y, 1), z = axis(at.z, 2);
    const wide::IntOf<F> i00 = index(x.first, y.first, z.first),
                         i10 = index(x.first, y.second, z.first),
                         i01 = index(x.first, y.first, z.second),
                         i11 = index(x.first, y.second, z.second);
    const wide::IntOf<F> step = (x.second - x.first) * channels;
    for (int32_t c = 0; c < channels; ++c) {
      const auto along_x = [&](const wide::IntOf<F>& i) {
        return mix(gather(values + c, i), gather(values + c, i + step), x.share);
      };
      out(c, mix(mix(along_x(i00), along_x(i10), y.share), mix(along_x(i01), along_x(i11), y.share),
                 z.share));
    }
  }

  /// Computes bounds on the values in a box of world space; see Volume::extremes().
  std::pair<float, float> range_in(const Aabb& box) const {
    Aabb inside;
    for (unsigned i = 0; i < 8; ++i) inside.expand(to_index_ * box.corner(i) + offset_);
    const Vec3 farthest = glm::max(glm::abs(box.lo), glm::abs(box.hi));
    std::array<std::vector<size_t>, 3> used;
    for (int a = 0; a < 3; ++a) {
      // Rounding errors of the transform are relative to its terms.
      float terms = 1 + std::abs(offset_[a]);
      for (int k = 0; k < 3; ++k) terms += std::abs(to_index_[k][a]) * farthest[k];
      used[static_cast<size_t>(a)] = indices(inside.lo[a], inside.hi[a], terms * 1e-6f, a);
    }
    float lo = kInfinity, hi = -kInfinity;
    for (const size_t z : used[2]) {
      for (const size_t y : used[1]) {
        const float* const row = grid_.values.data() + (z * grid_.size.y + y) * row_length();
        for (const size_t x : used[0]) {
          for (size_t c = 0; c < grid_.channels; ++c) {
            const float v = row[x * grid_.channels + c];
            lo = std::min(lo, v), hi = std::max(hi, v);
          }
        }
      }
    }
    constexpr float kRounding = 1e-6f;  // of interpolation
    return {lo - std::abs(lo) * kRounding, hi + std::abs(hi) * kRounding};
  }

  /// Adds the integrals of the channels along o + t d for 0 <= t <= length to `sums`. The grid is
  /// linear along each axis between the centres of voxels. So the integrand is a cubic polynomial
  /// between two planes of centres, of which two-point Gauss quadrature is exact.
  void integrate(const Vec3& o, const Vec3& d, float length, double* sums) const {
    const glm::dvec3 start = to_index_ * o + offset_, slope = to_index_ * d;
    const bool is_nearest = filter_ == VoxelFilter::kNearest;
    // Planes are at the integers, or half-way between them.
    const double shift = is_nearest ? 0.5 : 0;
    glm::dvec3 next, step;
    for (int a = 0; a < 3; ++a) {
      step[a] = slope[a] == 0 ? HUGE_VAL : 1 / std::abs(slope[a]);
      const double at = start[a] + shift;
      const double to_plane = slope[a] > 0 ? std::floor(at) + 1 - at : at - std::ceil(at) + 1;
      next[a] = slope[a] == 0 ? HUGE_VAL : to_plane * step[a];
    }
    for (double t = 0; t < length;) {
      const double end = std::min({next.x, next.y, next.z, double{length}});
      add_cell(start, slope, t, end, is_nearest, sums);
      for (int a = 0; a < 3; ++a) {
        if (next[a] <= end) next[a] += step[a];
      }
      t = end;
    }
  }

 private:
  /// Two neighbours along an axis, and the share of the second one.
  template <class F>
  struct Axis {
    wide::IntOf<F> first, second;
    F share;
  };

  size_t row_length() const { return size_t{grid_.size.x} * grid_.channels; }

  template <class F>
  static F mix(const F& a, const F& b, const F& share) {
    return a + (b - a) * share;
  }

  template <class F>
  Axis<F> axis(const F& at, int a) const {
    using namespace wide::formulas;
    using std::floor;
    const F first = floor(at);
    return {wrapped(first, a), wrapped(first + 1.f, a), at - first};
  }

  /// Returns the voxel for an index outside of the grid; valid even for NaN.
  template <class F>
  auto wrapped(const F& index, int a) const {
    using namespace wide::formulas;
    using plain::select, std::floor;
    const float n = size_[a];
    F i = index;
    if (wrap_ == VoxelWrap::kRepeat) i = i - n * floor((i + 0.5f) / n);
    if (wrap_ == VoxelWrap::kMirror) {
      i = i - 2 * n * floor((i + 0.5f) / (2 * n));
      i = select(i < n, i, 2 * n - 1 - i);
    }
    // These selections are false for NaN.
    i = select(i > 0.f, i, F(0.f));
    return to_int(select(i < n - 1, i, F(n - 1)));
  }

  template <class I>
  I index(const I& x, const I& y, const I& z) const {
    const auto channels = static_cast<int32_t>(grid_.channels);
    return ((z * static_cast<int32_t>(grid_.size.y) + y) * static_cast<int32_t>(grid_.size.x) + x) *
           channels;
  }

  /// Voxels along an axis that values between two positions depend on; `slack` is the error of the
  /// positions.
  std::vector<size_t> indices(float lo, float hi, float slack, int a) const {
    const float n = size_[a];
    const float half = filter_ == VoxelFilter::kNearest ? 0.5f : 0.f;
    float first = std::floor(lo + half - slack);
    float last = std::floor(hi + half + slack) + (half > 0 ? 0.f : 1.f);
    if (wrap_ == VoxelWrap::kClamp) {
      first = std::clamp(first, 0.f, n - 1), last = std::clamp(last, 0.f, n - 1);
    }
    std::vector<size_t> found;
    if (!(last - first < n)) {  // all, also for positions that aren't finite
      for (uint32_t i = 0; i < grid_.size[a]; ++i) found.push_back(i);
      return found;
    }
    for (float i = first; i <= last; ++i) found.push_back(static_cast<size_t>(wrapped(i, a)));
    return found;
  }

  /// Adds the integral over [t, end], between two planes.
  void add_cell(const glm::dvec3& start, const glm::dvec3& slope, double t, double end,
                bool is_nearest, double* sums) const {
    const double middle = (t + end) / 2, half = (end - t) / 2;
    const glm::dvec3 centre = start + slope * middle;
    if (is_nearest) {
      const glm::dvec3 nearest = glm::floor(centre + 0.5);
      const size_t i = voxel(nearest);
      for (size_t c = 0; c < grid_.channels; ++c) sums[c] += 2 * half * grid_.values[i + c];
      return;
    }
    const glm::dvec3 corner = glm::floor(centre);
    const glm::dvec3 a = centre - slope * (half / std::sqrt(3.)) - corner,
                     b = centre + slope * (half / std::sqrt(3.)) - corner;
    // Offsets of the two voxels along each axis, and their weights at both nodes.
    size_t offsets[3][2];
    double at_a[3][2], at_b[3][2];
    const size_t strides[] = {grid_.channels, row_length(), row_length() * grid_.size.y};
    for (int axis = 0; axis < 3; ++axis) {
      const auto first = static_cast<float>(corner[axis]);
      for (int k = 0; k < 2; ++k) {
        const int voxel = wrapped(first + static_cast<float>(k), axis);
        offsets[axis][k] = static_cast<size_t>(voxel) * strides[axis];
        at_a[axis][k] = k == 0 ? 1 - a[axis] : a[axis];
        at_b[axis][k] = k == 0 ? 1 - b[axis] : b[axis];
      }
    }
    for (int z = 0; z < 2; ++z) {
      for (int y = 0; y < 2; ++y) {
        const float* const row = grid_.values.data() + offsets[2][z] + offsets[1][y];
        const double row_a = half * at_a[2][z] * at_a[1][y], row_b = half * at_b[2][z] * at_b[1][y];
        for (int x = 0; x < 2; ++x) {
          const double factor = row_a * at_a[0][x] + row_b * at_b[0][x];
          for (size_t c = 0; c < grid_.channels; ++c) sums[c] += factor * row[offsets[0][x] + c];
        }
      }
    }
  }
  /// Returns the index of a voxel's first value.
  size_t voxel(const glm::dvec3& at) const {
    const Vec3 i(at);
    return static_cast<size_t>(index(wrapped(i.x, 0), wrapped(i.y, 1), wrapped(i.z, 2)));
  }

  VoxelGrid grid_;
  VoxelFilter filter_;
  VoxelWrap wrap_;
  Vec3 size_;
  glm::mat3 to_index_;
  Vec3 offset_;
};

}  // namespace kinome
