#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "clustered/cells/light_cells.h"
#include "clustered/kernels/candidate_kernels.h"
#include "clustered/product/choice/lobe_values.h"
#include "clustered/product/tiles/unit.h"

namespace kinome {

/// Candidates of groups as a structure of arrays, group by group. The candidates of each group are
/// padded to simd::kLobeLanes with directions without light. Derived structs add columns.
struct Candidates {
  std::vector<uint32_t> member;  ///< index of the point in the group
  std::vector<uint32_t> cell;    ///< index in CellLight
  std::vector<float> dx, dy, dz;
  std::vector<Rgb> radiance;
  std::vector<float> f[3];          ///< BSDF x cosine
  std::vector<float> lobe_density;  ///< LobeColumns::density
  std::vector<float> weight[3];     ///< the sum of all weights estimates the unshadowed light

  size_t size() const { return size_; }
  /// Memory only grows. New elements are not initialised.
  void resize(size_t size) {
    size_ = size;
    if (size <= member.size()) return;
    size = std::max(size, 2 * member.size());
    member.resize(size);
    cell.resize(size);
    radiance.resize(size);
    for (auto* const v :
         {&dx, &dy, &dz, &f[0], &f[1], &f[2], &lobe_density, &weight[0], &weight[1], &weight[2]}) {
      v->resize(size);
    }
  }

  /// Sets cell, direction and radiance of a candidate.
  void put(size_t i, uint32_t of_cell, const Vec3& d, const Rgb& light) {
    cell[i] = of_cell;
    dx[i] = d.x;
    dy[i] = d.y;
    dz[i] = d.z;
    radiance[i] = light;
  }
  Vec3 direction(size_t i) const { return {dx[i], dy[i], dz[i]}; }
  Rgb f_of(size_t i) const { return {f[0][i], f[1][i], f[2][i]}; }
  Rgb weight_of(size_t i) const { return {weight[0][i], weight[1][i], weight[2][i]}; }
  /// Returns the directions from index i to the end.
  Directions directions(size_t i) const { return {&member[i], &dx[i], &dy[i], &dz[i], size_ - i}; }
  LobeColumns lobe_columns(size_t i) { return {{&f[0][i], &f[1][i], &f[2][i]}, &lobe_density[i]}; }
  simd::WeightColumns weight_columns(size_t i, float* uncertainty) {
    return {{&f[0][i], &f[1][i], &f[2][i]},
            &radiance[i].x,
            &cell[i],
            {&weight[0][i], &weight[1][i], &weight[2][i]},
            uncertainty};
  }

 private:
  size_t size_ = 0;
};

/// Splits a group's control term among its members. The candidates are [first, candidates.size()).
/// Each member gets the terms of its own candidates and an equal share of the rest of `control`.
/// The rest is from a control variate that is the same for all members.
void split_control(const GroupView& group, const Candidates& candidates, size_t first,
                   const Rgb& control, const UnitSums& sums);

/// Candidates for distant light.
struct DistantCandidates : Candidates {
  std::vector<float> cell_density;  ///< density of drawing from the cells, per solid angle

  void resize(size_t size) {
    Candidates::resize(size);
    if (cell_density.size() < member.size()) cell_density.resize(member.size());
  }
  /// Sets a candidate to the given point. Sets cell_density to the density within the cell alone.
  void put_point(size_t i, const CellPoint& point) {
    put(i, point.cell, point.d, point.weight * point.density);
    cell_density[i] = point.density;
  }
  /// Sets a candidate to a direction without light.
  void put_nothing(size_t i, const Vec3& d) {
    put(i, 0, d, Rgb(0.f));
    cell_density[i] = 0;
  }
};

}  // namespace kinome
