#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "kinome/environment_grid.h"

/// Exact integrals over the cells of an environment's grid.
namespace kinome {

/// Integrals of functions of one angle over each interval of a grid, and the parts of them that
/// linear interpolation assigns to the intervals' ends.
class IntervalIntegrals {
 public:
  /// Integrates `f(angle)` over [(i + first) step, (i + first + 1) step], i < count. Gauss-Legendre
  /// quadrature with four points is exact up to rounding for sines over intervals as short as a
  /// grid's.
  template <class Function>
  IntervalIntegrals(int count, double first, double step, const Function& f) {
    constexpr double kNodes[2] = {0.33998104358485626, 0.86113631159405258};
    constexpr double kWeights[2] = {0.65214515486254614, 0.34785484513745386};
    whole_.resize(count);
    at_end_.resize(count);
    for (int i = 0; i < count; ++i) {
      for (int k = 0; k < 4; ++k) {
        const double t = 0.5 + 0.5 * (k < 2 ? -kNodes[k] : kNodes[k - 2]);
        const double value = 0.5 * step * kWeights[k % 2] * f((i + first + t) * step);
        whole_[i] += value;
        at_end_[i] += t * value;
      }
    }
  }
  double whole(int i) const { return whole_[i]; }
  /// Integral of f times a hat function: 1 at border `node` of the grid, 0 at all other borders,
  /// and linear in each of the intervals [begin, end).
  double at_node(int node, int begin, int end) const {
    return (node > begin ? at_end_[node - 1] : 0.) +
           (node < end ? whole_[node] - at_end_[node] : 0.);
  }

 private:
  std::vector<double> whole_, at_end_;
};

/// Integrals over solid angle of the directions of a grid, d = (sin phi sin theta, cos theta,
/// -cos phi sin theta). They are products of a function of the column and one of the row.
struct GridIntegrals {
  IntervalIntegrals sine, cosine, width;    ///< over phi: sin, cos, and 1
  IntervalIntegrals sine_squared, product;  ///< over theta: sin², and sin cos
  explicit GridIntegrals(const EnvironmentGrid& grid)
      : sine(grid.columns, grid.first_column, 2 * std::numbers::pi / grid.columns,
             [](double phi) { return std::sin(phi); }),
        cosine(grid.columns, grid.first_column, 2 * std::numbers::pi / grid.columns,
               [](double phi) { return std::cos(phi); }),
        width(grid.columns, 0, 2 * std::numbers::pi / grid.columns, [](double) { return 1.; }),
        sine_squared(grid.rows, 0, std::numbers::pi / grid.rows,
                     [](double theta) { return std::sin(theta) * std::sin(theta); }),
        product(grid.rows, 0, std::numbers::pi / grid.rows,
                [](double theta) { return std::sin(theta) * std::cos(theta); }) {}
};

}  // namespace kinome
