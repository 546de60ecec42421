#pragma once

#include "clustered/cells/light_cells.h"
#include "clustered/kernels/cell_kernels.h"
#include "clustered/product/lights/local_light.h"

namespace kinome {

class Caustics;

/// Light of one pass: all cells, and the points drawn in them. Indices of cells of local light
/// start at first_local(), after the cells of distant light. Immutable; thread-safe. Arguments
/// passed by reference or pointer must outlive it.
struct CellLight {
  /// Returns a sufficient number of points for this number of rays. Fewer points would add noise
  /// that all rays share. The maximum fits the cache of a core; more points gain nothing.
  static uint32_t points_for(double rays);
  const DistantCells& cells;
  const Emitter* environment;  ///< nullptr if there is none
  CellPoints points;
  const LocalLight* local;  ///< nullptr if there is none
  LocalPoints local_points;
  simd::CellColumns columns;
  const Caustics* caustics = nullptr;  ///< shares the light of chains of mirrors with EyeChains
  /// True if cells at the horizon of a flat surface have control terms.
  bool horizon_terms = true;
  PathSettings paths{{2, 5}, false};  ///< for camera rays that continue as paths
  /// Groups by which light is divided; nullptr if it isn't, as in pilots and trials.
  const LightGroups* groups = nullptr;
  uint32_t sky_group = 0;  ///< of the environment; 0 if light isn't divided

  /// Divides light by group. The groups must outlive this object.
  void divide_by(const LightGroups& by);
  uint32_t group_count() const {
    return groups ? static_cast<uint32_t>(groups->names().size()) : 1;
  }
  /// Returns the light group of an emitter; 0 if it is nullptr or light isn't divided.
  uint32_t group_of(const Emitter* emitter) const {
    if (!groups || !emitter) return 0;
    return emitter == environment ? sky_group : local->group_of(*emitter);
  }
  /// Returns 0 if light isn't divided, else `group`.
  uint32_t divided(uint32_t group) const { return groups ? group : 0; }
  /// The scene; nullptr if it has no surfaces that light passes straight.
  const transport::SceneTable* passing() const { return local ? local->passing() : nullptr; }
  CellLight(const DistantCells& cells, const Emitter* environment, CellPoints points,
            const LocalLight* local = nullptr, LocalPoints local_points = {});
  uint32_t first_local() const { return cells.padded_size(); }
  bool has_distant() const { return columns.count > 0; }
};

}  // namespace kinome
